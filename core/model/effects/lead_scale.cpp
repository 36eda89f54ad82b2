#include "core/model/effect.hpp"

namespace trammel {

/// dl_i = k_i s_i
Effect lead_scale() {
  return {.name = "lead_scale",
          .sentence =
              "displacement error growing in proportion to travel: screw lead error, or wind-up of "
              "screw and coupling (displacement data alone can't tell the two apart)",
          .needs = {Need::travel},
          .parameters = one_per_rail("k", "1", 1e-2),
          .basis = [](const Moment& m, int k) {
            Deviation d;
            d.dl_mm[k] = m.s_mm[k];
            return d;
          }};
}

}  // namespace trammel
