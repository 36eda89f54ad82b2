#pragma once
// What stands behind U besides the readings themselves: the budget of a corrected position.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/measure/noise.hpp"
#include "core/measure/reading.hpp"

namespace trammel {

/// What a campaign states of its instruments; what it leaves out is assumed, and named so.
struct BudgetFacts {
  std::string instrument = "tracker";          // of kInstruments
  std::optional<double> instrument_mpe_mm;     // largest permissible error of a coordinate
  std::optional<double> instrument_u_mm;       // or its standard uncertainty by calibration
  std::optional<double> nests_mm;              // half width: reflectors put back into their nests
  std::optional<double> frame_u_mm;            // standard uncertainty of the registered frame
  std::optional<double> alpha_per_k;           // expansion of what carries the rails
  std::optional<double> temperature_spread_k;  // half width between the times of measurement
  std::optional<double> length_mm;             // from the frame's origin to the rails
};

/// What is assumed of an instrument where nothing is stated.
struct Instrument {
  const char* name;
  double mpe_mm;      // largest permissible error
  double mpe_per_mm;  // and of each millimetre of travel
  double nests_mm;    // half width: of what is put back between readings
  double frame_u_mm;  // of a frame that is registered
  const char* from;
};
/// A tracker at 2 m (ASME B89.4.19); an interferometer with compensation of air and material, 0.5
/// ppm of the travel (Renishaw XL-80), and a grid encoder, 2 um (Heidenhain KGM), neither of which
/// is put back or registered: their own zero is the frame. Unknown: nothing is assumed, and said.
inline constexpr std::array<Instrument, 4> kInstruments = {{
    {"tracker", 0.015, 0, 0.005, 0.005, "of a laser tracker"},
    {"interferometer", 0, 0.5e-6, 0, 0, "of an interferometer"},
    {"grid-encoder", 0.002, 0, 0, 0, "of a grid encoder"},
    {"unknown", 0, 0, 0, 0, ""},
}};
/// Null where there is none of this name.
const Instrument* find_instrument(std::string_view name);

/// One source (GUM 4.3, 5.1): standard uncertainty = value / divisor x sensitivity.
struct BudgetRow {
  std::string name;          // "instrument"
  std::string source;        // "MPE, assumed"
  std::string distribution;  // "normal", "rectangular"
  double value = 0;          // standard uncertainty, or half width
  std::string unit = "mm";   // of value: mm, K
  double divisor = 1;        // 1; sqrt(3) of a rectangle
  double sensitivity = 1;    // mm per unit
  bool cancels = false;      // the same before and after a correction

  [[nodiscard]] double contribution_mm() const { return value / divisor * sensitivity; }
};

/// Rows for a coordinate of a corrected position. Instrument and frame are the same before and
/// after and cancel in an improvement; nests, temperature, model and repeats do not.
///   instrument  MPE / sqrt(3), or its calibration; nests / sqrt(3); frame: assumed as kInstruments
///               has them, and 0 with "not known" of an unknown instrument
///   temperature alpha L dT / sqrt(3): assumed steel's 12e-6 per K, half the span of the recorded
///               temperatures (1 K without records), L = R of the first chain
///   model       root mean square of the points' own standard uncertainty, where there is one
///   repeats     the robot's scatter beyond the tracker's, where repeats show one
/// A simulated tracker has no error but its noise: nothing is assumed of it. `u_model_mm`: nothing
/// without a correction. Proof: budget_test.cpp.
std::vector<BudgetRow> budget_of(const Campaign& campaign, const BudgetFacts& facts,
                                 const NoiseLevel& noise, const std::optional<double>& u_model_mm);

/// Relative standard uncertainty of mean after / mean before that the choice of points does not
/// show: the rows that do not cancel, less model and repeats, which the points themselves show.
/// Nothing where after is predicted from the readings before: then all rows cancel.
double relative_u(std::span<const BudgetRow> rows, double before_mm, double after_mm,
                  bool predicted);

/// Root of the sum of squares of all rows, mm; `with_model`: that row too.
double combined_mm(std::span<const BudgetRow> rows, bool with_model = true);

}  // namespace trammel
