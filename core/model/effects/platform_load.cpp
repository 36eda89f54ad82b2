#include "core/model/effect.hpp"

namespace trammel {

/// dl = G^T w, G = dX/dl: drives of equal stiffness under a constant wrench w = (fx, fy, m)
Effect platform_load() {
  return {.name = "platform_load",
          .sentence =
              "drives yielding to a constant force or torque on the platform: payload, hose, tilt "
              "of the table",
          .needs = {Need::travel},
          .parameters =
              {{.name = "fx", .unit = "mm", .usual_max = 1, .on = On::platform},
               {.name = "fy", .unit = "mm", .usual_max = 1, .joined = true, .on = On::platform},
               {.name = "m", .unit = "mm^2", .usual_max = 100, .on = On::platform}},
          .basis = [](const Moment& moment, int k) {
            Deviation d;
            d.dl_mm = moment.J_V.row(k).transpose();
            return d;
          }};
}

}  // namespace trammel
