#include "core/model/effect.hpp"
#include "core/units.hpp"

namespace trammel {

/// The slider of drive i turns by k_i s_i and its passive guide with it: across the guide the
/// platform moves by the lever (Abbe), and a platform that is a point turns as well,
///   dc_i = k_i s_i u_gamma . (C - (q + l) u_alpha),   dphi = k_i s_i
Effect guide_yaw() {
  return {.name = "guide_yaw",
          .sentence =
              "an axis that yaws as it travels: the error grows with travel times the lever arm "
              "(Abbe), as long as the other axis reaches out",
          .needs = {Need::travel},
          .parameters = one_per_rail("k", "deg/mm", 1e-4, On::passive),
          .basis = [](const Moment& m, int k) {
            const double turn_rad = rad_from_deg(m.s_mm[k]);
            Deviation d;
            d.dh_mm[k] = turn_rad * m.lever_mm[k];
            if (m.turns_with_axes) d.dX[2] = turn_rad;
            return d;
          }};
}

}  // namespace trammel
