#include "core/model/effect.hpp"
#include "core/units.hpp"

namespace trammel {

/// (x, y, phi) += v t
Effect tracker_drift() {
  return {.name = "tracker_drift",
          .sentence =
              "readings wandering steadily in time: tracker, its stand or the frame's nests moving",
          .needs = {Need::time},
          .parameters = {{"vx", "mm/h", -1, 0.2},
                         {.name = "vy", .unit = "mm/h", .usual_max = 0.2, .joined = true},
                         {"vphi", "deg/h", -1, 0.1}},
          .basis = [](const Moment& m, int k) {
            Deviation d;
            d.dX[k] = *m.time_h * (k == 2 ? rad_from_deg(1) : 1.0);
            return d;
          }};
}

}  // namespace trammel
