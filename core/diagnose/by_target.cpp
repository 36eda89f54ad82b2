#include "core/diagnose/by_target.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"
#include "core/mechanism/displacements.hpp"

namespace trammel {

namespace {

constexpr double kSameTargetMm = 1e-6;

struct Row {
  double off_mm = 0, direction = 0;
  int run = 0;
};

std::optional<AtTarget> fitted(const std::vector<Row>& rows) {
  const auto count = [&](double direction) {
    return std::ranges::count(rows, direction, &Row::direction);
  };
  if (count(1) < kFewestRuns || count(-1) < kFewestRuns) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd A(n, 3);
  Eigen::VectorXd d(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    A.row(i) << 1, 0.5 * row.direction, row.run;
    d[i] = row.off_mm;
  }
  const Eigen::MatrixXd inverse = inverse_symmetric(gram(A));
  const Eigen::VectorXd b = times(inverse, transposed_times(A, d));
  const double s2 = (d - times(A, b)).squaredNorm() / static_cast<double>(n - 3);
  return AtTarget{.readings = static_cast<int>(n),
                  .reversal_mm = b[1],
                  .reversal_std_mm = std::sqrt(s2 * inverse(1, 1)),
                  .drift_mm = b[2],
                  .drift_std_mm = std::sqrt(s2 * inverse(2, 2))};
}

}  // namespace

std::vector<AtTarget> reversals_by_target(const Machine& machine,
                                          std::span<const Reading> readings) {
  std::vector<AtTarget> all;
  if (!machine.kind->has_point_platform()) return all;
  for (int chain = 0; chain < machine.kind->n_chains; ++chain) {
    const int coordinate = drive_name(machine, chain).front() == 'x' ? 0 : 1;
    if (!machine.measured[static_cast<std::size_t>(coordinate)]) continue;
    std::map<std::vector<long long>, std::vector<Row>> groups;  // by epoch and place
    std::map<std::vector<long long>, double> targets_mm;
    for (const Reading& r : readings) {
      const double direction = directions_of(r.conditions.cmd_mm - r.conditions.from_mm)[chain];
      if (!r.measured || direction == 0) continue;
      std::vector<long long> place = {r.conditions.epoch};
      for (const double v : r.target.vector()) place.push_back(std::llround(v / kSameTargetMm));
      std::vector<Row>& rows = groups[place];
      const auto run = std::ranges::count(rows, direction, &Row::direction);
      rows.push_back({r.measured->vector()[coordinate] - r.target.vector()[coordinate], direction,
                      static_cast<int>(run)});
      targets_mm[place] = r.target.vector()[coordinate];
    }
    for (const auto& [place, rows] : groups) {
      auto at = fitted(rows);
      if (!at) continue;
      at->chain = chain;
      at->target_mm = targets_mm[place];
      all.push_back(*at);
    }
  }
  return all;
}

std::string in_words(const AtTarget& at, const Machine& machine) {
  constexpr double kUm = 1000;
  char text[200];
  std::snprintf(
      text, sizeof text,
      "%s at %g mm: reversal %+.2f +- %.2f um, drift %+.2f +- %.2f um a run (%d readings)",
      drive_name(machine, at.chain).c_str(), at.target_mm, kUm * at.reversal_mm,
      kUm * at.reversal_std_mm, kUm * at.drift_mm, kUm * at.drift_std_mm, at.readings);
  return text;
}

}  // namespace trammel
