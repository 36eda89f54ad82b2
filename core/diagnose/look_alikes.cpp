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
  std::string effect;  // that it looks like
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

void add_thermal(const ResidualSpace& space, std::vector<Pretender>& kinds) {
  const bool recorded =
      std::all_of(space.readings.begin(), space.readings.end(),
                  [](const Reading& r) { return r.conditions.temp_degc && r.conditions.time_s; });
  if (!recorded) return;
  for (const double lag_h : {0.25, 0.5, 1.0}) {
    kinds.push_back({"thermal_growth", "rails that follow the thermometer",
                     std::to_string(static_cast<int>(60 * lag_h)) + " min late",
                     [&space, lag_h](const Reading& r, const Moment& m, int k) {
                       const double degc =
                           earlier_degc(space.readings, *r.conditions.time_s - 3600 * lag_h);
                       return along(k, m.l_mm[k] * (degc - kReferenceTemperatureDegc));
                     }});
  }
}

std::vector<Pretender> kinds_for(const ResidualSpace& space) {
  std::vector<Pretender> kinds = {
      {"backlash", "rails that lose motion", "in proportion to the last move",
       [](const Reading&, const Moment& m, int k) { return along(k, m.travel_mm[k]); }}};
  add_thermal(space, kinds);
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

}  // namespace

std::optional<LookAlike> best_look_alike(const ResidualSpace& space, const Library& library,
                                         const Candidate& best) {
  std::optional<LookAlike> found;
  for (const Pretender& kind : kinds_for(space)) {
    for (const int effect : best.effects) {
      if (effect_catalogue()[static_cast<std::size_t>(effect)].name != kind.effect) continue;
      const std::vector<int> own = units_of(library, best, effect, true);
      const Eigen::MatrixXd kept =
          orthonormal(space.project(signals_of(library, units_of(library, best, effect, false))));
      const auto apart = [&](const Eigen::MatrixXd& signal) {
        const Eigen::MatrixXd projected = space.project(signal);
        return Eigen::MatrixXd(projected - kept * (kept.transpose() * projected));
      };
      std::vector<Eigen::VectorXd> columns;
      for (const int u : own) {
        for (const int k : library.units[static_cast<std::size_t>(u)].parameters) {
          columns.push_back(whitened_signal(
              space, [&](const Reading& r, const Moment& m) { return kind.basis(r, m, k); }));
        }
      }
      Eigen::MatrixXd alike(space.rows(), static_cast<Eigen::Index>(columns.size()));
      for (std::size_t c = 0; c < columns.size(); ++c)
        alike.col(static_cast<Eigen::Index>(c)) = columns[c];
      const Eigen::MatrixXd effect_span = orthonormal(apart(signals_of(library, own)));
      const Eigen::MatrixXd alike_span = orthonormal(apart(alike));
      const Eigen::VectorXd seen = effect_span * (effect_span.transpose() * space.residual);
      const Eigen::VectorXd seen_alike = alike_span * (alike_span.transpose() * space.residual);
      // what either can't imitate of the other as fitted
      const double told = std::max(
          (seen - alike_span * (alike_span.transpose() * seen)).squaredNorm(),
          (seen_alike - effect_span * (effect_span.transpose() * seen_alike)).squaredNorm());
      const double evidence = seen_alike.squaredNorm() - seen.squaredNorm();
      if (told < kTellApart || evidence <= 0 || (found && evidence <= found->evidence)) continue;
      found = LookAlike{{kind.what, kind.when,
                         chi2_tail(seen_alike.squaredNorm(), static_cast<double>(alike.cols())),
                         seen_alike.squaredNorm(), static_cast<int>(alike.cols())},
                        evidence};
    }
  }
  return found;
}

}  // namespace trammel
