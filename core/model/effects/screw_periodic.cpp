#include <cmath>

#include "core/model/effect.hpp"
#include "core/units.hpp"

namespace trammel {

/// dl_i = a_i sin(2 pi l_i / lead) + b_i cos(2 pi l_i / lead)
Effect screw_periodic() {
  std::vector<EffectParameter> parameters;
  for (int rail = 0; rail < kChains; ++rail) {
    parameters.push_back({"a_" + std::to_string(rail + 1), "mm", rail, 0.1});
    parameters.push_back({"b_" + std::to_string(rail + 1), "mm", rail, 0.1});
    parameters.back().joined = true;  // sine and cosine are one wave
  }
  return {
      .name = "screw_periodic",
      .sentence =
          "error repeating with every turn of the screw: eccentric mounting, coupling or encoder",
      .needs = {Need::travel},
      .parameters = parameters,
      .basis = [](const Moment& m, int k) {
        const int rail = k / 2;
        const double turn = 2 * kPi * m.l_mm[rail] / m.lead_mm[rail];
        Deviation d;
        d.dl_mm[rail] = k % 2 == 0 ? std::sin(turn) : std::cos(turn);
        return d;
      }};
}

}  // namespace trammel
