#include "core/model/effect.hpp"
#include "core/units.hpp"

namespace trammel {

/// (x, y, phi) += v t
Effect tracker_drift() {
  return {
      .name = "tracker_drift",
      .sentence =
          "readings wandering steadily in time: tracker, its stand or the frame's nests moving",
      .needs = {Need::time},
      .parameters =
          {{.name = "vx", .unit = "mm/h", .usual_max = 0.2, .on = On::coordinate},
           {.name = "vy", .unit = "mm/h", .usual_max = 0.2, .joined = true, .on = On::coordinate},
           {.name = "vphi", .unit = "deg/h", .usual_max = 0.1, .on = On::coordinate}},
      .basis = [](const Moment& m, int k) {
        Deviation d;
        d.dX[k] = *m.time_h * (k == 2 ? rad_from_deg(1) : 1.0);
        return d;
      }};
}

}  // namespace trammel
