#include "core/diagnose/look_alikes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/model/effect.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

/// Deviation at a reading per unit of parameter `k`, as an effect's basis has it.
using Basis = std::function<Deviation(const Reading&, const Moment&, int k)>;

struct Pretender {
  std::vector<std::string> effects;  // that it may be taken for
  std::string what, when;
  Basis basis;
};

Deviation along(int rail, double dl_mm) {
  Deviation d;
  d.dl_mm[rail] = dl_mm;
  return d;
}

/// Temperature `lag_h` before a reading, from the readings' own record (the first one before it).
double earlier_degc(const std::vector<Reading>& readings, double time_s) {
  auto before = readings.front().conditions;
  for (const Reading& r : readings) {
    if (*r.conditions.time_s <= time_s && *r.conditions.time_s >= *before.time_s)
      before = r.conditions;
  }
  return *before.temp_degc;
}

/// What goes with temperature or time in a way that growth and drift do too.
void add_slow(const ResidualSpace& space, std::vector<Pretender>& kinds) {
  const std::vector<Reading>& readings = space.readings;
  const bool timed = std::ranges::all_of(
      readings, [](const Reading& r) { return r.conditions.time_s.has_value(); });
  if (!timed) return;
  const double first_s = *std::ranges::min(readings, {}, [](const Reading& r) {
                            return *r.conditions.time_s;
                          }).conditions.time_s;
  for (const int within_min : {5, 10, 15, 20, 30}) {
    kinds.push_back({{"thermal_growth", "tracker_drift"},
                     "rails that settle after the start",
                     "within " + std::to_string(within_min) + " min",
                     [=](const Reading& r, const Moment&, int k) {
                       const double since_s = *r.conditions.time_s - first_s;
                       return along(k, std::exp(-since_s / (60 * within_min)));
                     }});
  }
  const bool recorded = std::ranges::all_of(
      readings, [](const Reading& r) { return r.conditions.temp_degc.has_value(); });
  if (!recorded) return;
  for (const int lag_min : {10, 20, 30, 45, 60}) {
    kinds.push_back({{"thermal_growth", "tracker_drift"},
                     "rails that follow the thermometer",
                     std::to_string(lag_min) + " min late",
                     [&readings, lag_min](const Reading& r, const Moment& m, int k) {
                       const double degc =
                           earlier_degc(readings, *r.conditions.time_s - 60 * lag_min);
                       return along(k, m.l_mm[k] * (degc - kReferenceTemperatureDegc));
                     }});
  }
}

std::vector<Pretender> kinds_for(const ResidualSpace& space) {
  std::vector<Pretender> kinds = {
      {{"backlash"},
       "rails that lose motion",
       "in proportion to the last move",
       [](const Reading&, const Moment& m, int k) { return along(k, m.travel_mm[k]); }}};
  add_slow(space, kinds);
  return kinds;
}

/// Units of `best` with (`of_it`) or without the effect.
std::vector<int> units_of(const Library& library, const Candidate& best, int effect, bool of_it) {
  std::vector<int> units;
  for (const int u : best.units) {
    if ((library.units[static_cast<std::size_t>(u)].effect == effect) == of_it) units.push_back(u);
  }
  return units;
}

Eigen::MatrixXd signals_of(const Library& library, const std::vector<int>& units) {
  std::vector<int> columns;
  for (const int u : units) {
    const auto& own = library.units[static_cast<std::size_t>(u)].columns;
    columns.insert(columns.end(), own.begin(), own.end());
  }
  return library.signals(Eigen::all, columns);
}

/// What of the columns stands beside an orthonormal span.
Eigen::MatrixXd beside(const Eigen::MatrixXd& span, const Eigen::MatrixXd& columns) {
  return without(span, columns);
}

/// One effect of the best set, taken out: the span that it leaves free, and what it explains there.
struct Place {
  Eigen::MatrixXd kept;  // orthonormal: what stays named
  Eigen::MatrixXd span;  // of the effect, beside it
  Eigen::VectorXd seen;  // of the residual, in that span
  double price = 0;      // of the effect's units
};

Place place_of(const ResidualSpace& space, const Library& library, const Candidate& best,
               int effect) {
  const std::vector<int> others = units_of(library, best, effect, false);
  Place place{
      .kept = orthonormal(space.project(signals_of(library, others))), .span = {}, .seen = {}};
  place.span = orthonormal(beside(
      place.kept, space.project(signals_of(library, units_of(library, best, effect, true)))));
  place.seen = within(place.span, space.residual);
  place.price = price_of(library, best.units) - price_of(library, others);
  return place;
}

/// The rails of the look-alike that earn most: each choice of some of the three.
void try_rails(const ResidualSpace& space, const Place& place, const Eigen::MatrixXd& rails,
               const Pretender& kind, std::optional<LookAlike>& found) {
  for (unsigned choice = 1; choice < 1U << kChains; ++choice) {
    std::vector<int> chosen;
    for (int k = 0; k < kChains; ++k) {
      if ((choice >> k & 1U) != 0) chosen.push_back(k);
    }
    const Eigen::MatrixXd span = orthonormal(beside(place.kept, rails(Eigen::all, chosen)));
    const Eigen::VectorXd seen = within(span, space.residual);
    // what either can't imitate of the other as fitted
    const double told =
        std::max(without(span, place.seen).squaredNorm(), without(place.span, seen).squaredNorm());
    const auto n = static_cast<double>(chosen.size());
    const double price =
        kPriceOfName + kPriceOfParameter + (n - 1) * (kPriceOfFurther + 2 * std::log(kChains));
    const double evidence = seen.squaredNorm() - price - (place.seen.squaredNorm() - place.price);
    if (told < kTellApart || evidence <= 0 || (found && evidence <= found->evidence)) continue;
    found = LookAlike{{kind.what, kind.when, chi2_tail(seen.squaredNorm(), n), seen.squaredNorm(),
                       static_cast<int>(chosen.size())},
                      evidence};
  }
}

}  // namespace

std::optional<LookAlike> best_look_alike(const ResidualSpace& space, const Library& library,
                                         const Candidate& best) {
  std::optional<LookAlike> found;
  for (const int effect : best.effects) {
    const std::string& name = effect_catalogue()[static_cast<std::size_t>(effect)].name;
    const Place place = place_of(space, library, best, effect);
    for (const Pretender& kind : kinds_for(space)) {
      if (std::ranges::find(kind.effects, name) == kind.effects.end()) continue;
      Eigen::MatrixXd rails(space.rows(), kChains);
      for (int k = 0; k < kChains; ++k) {
        rails.col(k) = whitened_signal(
            space, [&](const Reading& r, const Moment& m) { return kind.basis(r, m, k); });
      }
      try_rails(space, place, space.project(rails), kind, found);
    }
  }
  return found;
}

}  // namespace trammel
