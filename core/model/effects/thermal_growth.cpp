#include "core/model/effect.hpp"
#include "core/units.hpp"

namespace trammel {

/// dl_i = c_i l_i (T - 20)
Effect thermal_growth() {
  return {.name = "thermal_growth",
          .sentence = "screws growing with the machine's temperature (steel: 1.2e-5 1/K)",
          .needs = {Need::temperature},
          .parameters = one_per_rail("c", "1/K", 1e-4),
          .basis = [](const Moment& m, int k) {
            Deviation d;
            d.dl_mm[k] = m.l_mm[k] * (*m.temp_degc - kReferenceTemperatureDegc);
            return d;
          }};
}

}  // namespace trammel
