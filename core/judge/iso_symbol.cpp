#include "core/judge/iso_symbol.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/error.hpp"
#include "core/statistics/limits.hpp"
#include "core/statistics/random.hpp"

namespace trammel {

namespace {

// The mean of so many copies is known to some 1 % for a single repeatability, better for the rest.
constexpr std::size_t kMostCopies = 400, kFewestCopies = 20;
constexpr std::size_t kReadingsOfAllCopies = 200000;  // 0.1 s

}  // namespace

void add_floors(std::span<IsoSymbol* const> symbols, std::span<const Reading> readings,
                const TrackerSigma& sigma,
                const std::function<std::vector<IsoSymbol>(std::span<const Reading>)>& symbols_of) {
  if (std::ranges::none_of(symbols, [](const IsoSymbol* s) { return s->value.has_value(); })) {
    return;
  }
  const std::size_t copies =
      std::clamp(kReadingsOfAllCopies / readings.size(), kFewestCopies, kMostCopies);
  std::vector<double> sums(symbols.size(), 0);
  std::vector<Reading> perfect(readings.begin(), readings.end());
  for (std::size_t copy = 0; copy < copies; ++copy) {
    Random random = Random::stream(1, "perfect robot", copy);
    for (Reading& r : perfect) {
      if (!r.measured) continue;
      const double x = random.normal(), y = random.normal(), phi = random.normal();
      r.measured = Pose{r.target.x_mm + sigma.xy_mm * x, r.target.y_mm + sigma.xy_mm * y,
                        r.target.phi_rad + sigma.phi_rad * phi};
    }
    const std::vector<IsoSymbol> found = symbols_of(perfect);
    TRAMMEL_ASSERT(found.size() == symbols.size());
    for (std::size_t k = 0; k < found.size(); ++k) sums[k] += std::abs(found[k].value.value_or(0));
  }
  for (std::size_t k = 0; k < symbols.size(); ++k) {
    if (symbols[k]->value) symbols[k]->floor = sums[k] / static_cast<double>(copies);
  }
}

std::string drift_words(std::span<const std::vector<double>> series_mm, double level) {
  double tt = 0, td = 0, dd = 0, freedom = -1;
  for (const std::vector<double>& series : series_mm) {
    const auto n = static_cast<double>(series.size());
    if (n < 2) continue;
    double mean = 0;
    for (const double v : series) mean += v / n;
    for (std::size_t k = 0; k < series.size(); ++k) {
      const double t = static_cast<double>(k) / (n - 1) - 0.5, d = series[k] - mean;
      tt += t * t;
      td += t * d;
      dd += d * d;
    }
    freedom += n - 1;
  }
  if (freedom < 1) return "";
  const double change = td / tt;
  const double error = std::sqrt(std::max(0.0, dd - td * td / tt) / freedom / tt);
  if (std::abs(change) <= student_limit(level, freedom) * error) return "";
  char text[160];
  std::snprintf(text, sizeof text,
                "the visits drift by %+.4f mm from first to last (beyond chance, %g %%): their "
                "scatter holds it",
                change, 100 * level);
  return text;
}

}  // namespace trammel
