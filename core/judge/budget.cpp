#include "core/judge/budget.hpp"

#include <algorithm>
#include <cmath>

namespace trammel {

namespace {

const double kRectangle = std::sqrt(3.0);
constexpr const char *kModelRow = "model", *kRepeatsRow = "repeats";

struct Assumed {
  double value = 0;
  std::string what = {};
};

/// What is stated, else what is assumed: nothing of a simulated instrument.
BudgetRow row_of(const std::string& name, const std::optional<double>& stated,
                 const std::string& source, const Assumed& assumed, bool simulated,
                 bool rectangular) {
  BudgetRow row{.name = name,
                .source = source + ", as stated",
                .distribution = rectangular ? "rectangular" : "normal",
                .value = stated.value_or(simulated ? 0 : assumed.value),
                .divisor = rectangular ? kRectangle : 1};
  if (!stated) row.source = simulated ? "simulated: none" : source + ", " + assumed.what;
  return row;
}

/// Half the span of the recorded temperatures.
std::optional<double> recorded_spread_k(const Campaign& campaign) {
  std::optional<double> low, high;
  for (const Reading& r : campaign.readings) {
    if (!r.measured || !r.conditions.temp_degc) continue;
    low = std::min(low.value_or(INFINITY), *r.conditions.temp_degc);
    high = std::max(high.value_or(-INFINITY), *r.conditions.temp_degc);
  }
  if (!low) return std::nullopt;
  return (*high - *low) / 2;
}

/// What grows where the budget states no length: from O_A to the end of the first rail of a 3-PRR,
/// else the longest stroke.
double longest_mm(const Machine& machine) {
  if (machine.kind->chain == &kPrrChain) return geometry_of(machine).chains.front().R_mm;
  double longest = 0;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    const Limits& limits = machine.drives[static_cast<std::size_t>(i)].limits;
    longest = std::max(longest, limits.l_max_mm - limits.l_min_mm);
  }
  return longest;
}

BudgetRow temperature_row(const Campaign& campaign, const BudgetFacts& facts) {
  const auto recorded = recorded_spread_k(campaign);
  const double spread = recorded.value_or(1.0);
  BudgetRow row = row_of("temperature", facts.temperature_spread_k, "spread between measurements",
                         {spread, recorded ? "half of what was recorded" : "assumed"},
                         campaign.simulated, true);
  row.unit = "K";
  const double alpha = facts.alpha_per_k.value_or(12e-6);
  row.sensitivity = alpha * facts.length_mm.value_or(longest_mm(campaign.machine));
  if (!facts.alpha_per_k && row.value > 0) row.source += "; alpha of steel assumed";
  return row;
}

/// Where repeats exceed the stated sigma, what the robot adds to it: less is in the model's row.
BudgetRow repeats_row(const NoiseLevel& noise) {
  BudgetRow row{.name = kRepeatsRow, .source = {}, .distribution = "normal"};
  if (!noise.repeats) {
    row.source = "no pose was measured twice: in the model's lack of fit";
  } else if (!noise.stated) {
    row.source = "no sigma stated: the robot's scatter counts as a reading's";
  } else if (noise.source == NoiseLevel::Source::tracker) {
    row.source = "repeats scatter as the tracker does";
  } else {
    row.source = "scatter of repeats beyond the tracker's, degrees of freedom: " +
                 std::to_string(2 * noise.degrees_of_freedom);
    row.value = std::sqrt(std::max(
        0.0, noise.sigma.xy_mm * noise.sigma.xy_mm - noise.stated->xy_mm * noise.stated->xy_mm));
  }
  return row;
}

}  // namespace

const Instrument* find_instrument(std::string_view name) {
  const auto* at = std::ranges::find(kInstruments, name, &Instrument::name);
  return at == kInstruments.end() ? nullptr : at;
}

std::vector<BudgetRow> budget_of(const Campaign& campaign, const BudgetFacts& facts,
                                 const NoiseLevel& noise, const std::optional<double>& u_model_mm) {
  const bool simulated = campaign.simulated;
  const Instrument& instrument = *find_instrument(facts.instrument);
  const bool unknown = *instrument.from == '\0';
  const std::string assumed =
      unknown ? "not known, and not counted" : std::string("assumed ") + instrument.from;
  const double mpe_mm = instrument.mpe_mm + instrument.mpe_per_mm * longest_mm(campaign.machine);
  std::vector<BudgetRow> rows;
  rows.push_back(facts.instrument_u_mm ? row_of("instrument", facts.instrument_u_mm, "calibration",
                                                {}, simulated, false)
                                       : row_of("instrument", facts.instrument_mpe_mm, "MPE",
                                                {mpe_mm, assumed}, simulated, true));
  rows.back().cancels = true;
  // what is put back or registered is a row of who does so
  if (instrument.nests_mm > 0 || facts.nests_mm) {
    rows.push_back(row_of("nests", facts.nests_mm, "reflectors put back",
                          {instrument.nests_mm, assumed}, simulated, true));
  }
  if (instrument.frame_u_mm > 0 || facts.frame_u_mm) {
    rows.push_back(row_of("frame", facts.frame_u_mm, "registration",
                          {instrument.frame_u_mm, assumed}, simulated, false));
    rows.back().cancels = true;
  }
  rows.push_back(temperature_row(campaign, facts));
  if (u_model_mm) {
    rows.push_back({.name = kModelRow,
                    .source = "what the correction knows of itself",
                    .distribution = "normal",
                    .value = *u_model_mm});
  }
  rows.push_back(repeats_row(noise));
  return rows;
}

double combined_mm(std::span<const BudgetRow> rows, bool with_model) {
  double squares = 0;
  for (const BudgetRow& row : rows) {
    if (row.name == kModelRow && !with_model) continue;
    squares += row.contribution_mm() * row.contribution_mm();
  }
  return std::sqrt(squares);
}

double relative_u(std::span<const BudgetRow> rows, double before_mm, double after_mm,
                  bool predicted) {
  if (predicted) return 0;
  double squares = 0;
  for (const BudgetRow& row : rows) {
    const bool shown = row.name == kModelRow || row.name == kRepeatsRow;
    if (!row.cancels && !shown) squares += row.contribution_mm() * row.contribution_mm();
  }
  return std::sqrt(squares) * std::hypot(1 / before_mm, 1 / after_mm);
}

}  // namespace trammel
