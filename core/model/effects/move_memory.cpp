#include <cmath>

#include "core/model/effect.hpp"

namespace trammel {

/// dl_i = -v_i dir_i exp(-|cmd - from| / d)
Effect move_memory() {
  auto parameters = one_per_rail("v", "mm", 0.1);
  parameters.push_back({"d", "mm", -1, 30, 1, false, On::shape});
  return {.name = "move_memory",
          .sentence =
              "short moves stop short, long ones do not: what a move leaves behind is wiped out by "
              "longer ones (friction, wind-up that creeps back)",
          .needs = {Need::direction},
          .parameters = parameters,
          .basis =
              [](const Moment& m, int k) {
                Deviation d;
                d.dl_mm[k] = -m.direction[k] * std::exp(-std::abs(m.travel_mm[k]) / m.fading_mm);
                return d;
              },
          .recall = [](Moment& m, const Eigen::VectorXd& v, const Conditions&,
                       const History*) { m.fading_mm = v[3]; }};
}

}  // namespace trammel
