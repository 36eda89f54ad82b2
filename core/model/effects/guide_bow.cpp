#include "core/model/effect.hpp"

namespace trammel {

/// B_i leaves its line by c_i s_i^2 along the rail's normal
Effect guide_bow() {
  return {
      .name = "guide_bow",
      .sentence =
          "a rail that is bent: the carriage leaves its straight line with the square of travel",
      .needs = {Need::travel},
      .parameters = one_per_rail("c", "1/mm", 5e-5),
      .basis = [](const Moment& m, int k) {
        Deviation d;
        d.dh_mm[k] = m.s_mm[k] * m.s_mm[k];
        return d;
      }};
}

}  // namespace trammel
