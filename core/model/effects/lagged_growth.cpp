#include "core/model/effect.hpp"
#include "core/model/history.hpp"
#include "core/units.hpp"

namespace trammel {

/// dl_i = c_i l_i (F - 20), F the temperature behind a lag of first order tau (history.hpp)
Effect lagged_growth() {
  auto parameters = one_per_rail("c", "1/K", 1e-4);
  parameters.push_back({"tau", "s", -1, 6 * 3600.0, 60, false, On::shape});
  return {
      .name = "lagged_growth",
      .sentence =
          "screws growing with the machine's temperature, later than the thermometer shows it "
          "(steel: 1.2e-5 1/K)",
      .needs = {Need::temperature, Need::time},
      .parameters = parameters,
      .basis =
          [](const Moment& m, int k) {
            Deviation d;
            d.dl_mm[k] = m.l_mm[k] * (*m.late_degc - kReferenceTemperatureDegc);
            return d;
          },
      .recall =
          [](Moment& m, const Eigen::VectorXd& v, const Conditions& at, const History* history) {
            m.late_degc = m.temp_degc;
            if (history != nullptr && m.temp_degc && m.time_h)
              m.late_degc = history->late_degc(at, v[3]);
          }};
}

}  // namespace trammel
