#include "core/model/effect.hpp"
#include "core/model/history.hpp"

namespace trammel {

/// dl_i = -v_i mean over radii r (octaves, from the least to the largest) of (l - F_r) / r, F_r the
/// play operator of radius r along the path (history.hpp)
Effect hysteresis() {
  auto parameters = one_per_rail("v", "mm", 0.1);
  parameters.push_back({"r_least", "mm", -1, 64, 1, false, On::choice});
  parameters.push_back({"r_largest", "mm", -1, 64, 1, false, On::choice});
  return {
      .name = "hysteresis",
      .sentence =
          "the stage lags behind its path: friction against a soft drive, taken up over the "
          "length of a reversal and not at once, as play is",
      .needs = {Need::direction},
      .parameters = parameters,
      .basis =
          [](const Moment& m, int k) {
            Deviation d;
            d.dl_mm[k] = -m.taken[k];
            return d;
          },
      .recall =
          [](Moment& m, const Eigen::VectorXd& v, const Conditions& at, const History* history) {
            m.taken = history != nullptr ? history->taken(at, v[3], v[4]) : m.direction;
          }};
}

}  // namespace trammel
