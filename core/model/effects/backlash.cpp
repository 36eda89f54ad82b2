#include "core/model/effect.hpp"

namespace trammel {

/// dl_i = -(w_i / 2) dir_i
Effect backlash() {
  auto parameters = one_per_rail("w", "mm", 0.5);
  for (auto& p : parameters) p.usual_min = 0;  // the stage lags its command, it never leads
  return {.name = "backlash",
          .sentence =
              "the stage stops short by a fixed amount, on the side it comes from: play in nut, "
              "coupling or gear",
          .needs = {Need::direction},
          .parameters = parameters,
          .basis = [](const Moment& m, int k) {
            Deviation d;
            d.dl_mm[k] = -0.5 * m.direction[k];
            return d;
          }};
}

}  // namespace trammel
