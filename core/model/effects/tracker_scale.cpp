#include "core/model/effect.hpp"

namespace trammel {

/// (x, y) *= 1 + m
Effect tracker_scale() {
  return {.name = "tracker_scale",
          .sentence =
              "the tracker's millimetre is not the machine's: wavelength, refraction, or its scale "
              "factor",
          .needs = {Need::travel},
          .parameters = {{.name = "m", .unit = "1", .usual_max = 2e-4, .on = On::reading}},
          .basis = [](const Moment& moment, int) {
            Deviation d;
            d.dX << moment.pose.x_mm, moment.pose.y_mm, 0;
            return d;
          }};
}

}  // namespace trammel
