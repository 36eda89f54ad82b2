#include "core/model/effect.hpp"

namespace trammel {

/// dl = G^T w, G = dX/dl: drives of equal stiffness under a constant wrench w = (fx, fy, m)
Effect platform_load() {
  return {.name = "platform_load",
          .sentence =
              "drives yielding to a constant force or torque on the platform: payload, hose, tilt "
              "of the table",
          .needs = {Need::travel},
          .parameters = {{"fx", "mm", -1, 1.0},
                         {.name = "fy", .unit = "mm", .usual_max = 1.0, .joined = true},
                         {"m", "mm^2", -1, 100.0}},
          .basis = [](const Moment& moment, int k) {
            Deviation d;
            d.dl_mm = moment.J_V.row(k).transpose();
            return d;
          }};
}

}  // namespace trammel
