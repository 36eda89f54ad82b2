#include "core/model/effect.hpp"

namespace trammel {

/// dl_i = q_i s_i^2
Effect lead_curvature() {
  return {.name = "lead_curvature",
          .sentence =
              "displacement error growing with the square of travel: a screw whose lead changes "
              "along it",
          .needs = {Need::travel},
          .parameters = one_per_rail("q", "1/mm", 2e-5),
          .basis = [](const Moment& m, int k) {
            Deviation d;
            d.dl_mm[k] = m.s_mm[k] * m.s_mm[k];
            return d;
          }};
}

}  // namespace trammel
