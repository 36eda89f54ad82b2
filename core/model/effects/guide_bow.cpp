#include "core/model/effect.hpp"

namespace trammel {

/// A guide leaves its line by c_i g_i^2 along its normal, g_i the travel along it: B_i of a PRR,
/// the platform of a PPR (the straightness of an XY stage's other axis)
Effect guide_bow() {
  return {
      .name = "guide_bow",
      .sentence =
          "a rail that is bent: the carriage leaves its straight line with the square of travel",
      .needs = {Need::travel},
      .parameters = one_per_rail("c", "1/mm", 5e-5, On::guide),
      .basis = [](const Moment& m, int k) {
        Deviation d;
        d.dh_mm[k] = m.guide_mm[k] * m.guide_mm[k];
        return d;
      }};
}

}  // namespace trammel
