#include "core/judge/iso230.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/mechanism/nominal_machine.hpp"

namespace trammel {

namespace {

constexpr double kAloneMm = 1e-3;  // a rail displaced less stands at home
constexpr double kMovesMm = 1e-6;  // a last move shorter than this has no direction
constexpr double kFollows = 0.01;  // of a drive, by a coordinate: less does not say where it stands

struct Runs {
  double mean = 0, s = 0;
};

Runs runs_of(const std::vector<double>& x) {
  TRAMMEL_ASSERT(x.size() >= 2);
  const auto n = static_cast<double>(x.size());
  Runs runs;
  for (const double v : x) runs.mean += v / n;
  for (const double v : x) runs.s += (v - runs.mean) * (v - runs.mean);
  runs.s = std::sqrt(runs.s / (n - 1));
  return runs;
}

/// Largest less smallest of what was put in.
class Range {
 public:
  void add(double v) {
    low_ = std::min(low_, v);
    high_ = std::max(high_, v);
  }
  [[nodiscard]] double width() const { return high_ - low_; }

 private:
  double low_ = INFINITY, high_ = -INFINITY;
};

/// The rail (from 0) that the target pose displaces alone; -1: several; 3: none, it is home.
int rail_alone(const Displacements& from_home) {
  int alone = kChains;
  for (int i = 0; i < kChains; ++i) {
    if (std::abs(from_home[i]) <= kAloneMm) continue;
    if (alone != kChains) return -1;
    alone = i;
  }
  return alone;
}

/// The measured pose, with its target's coordinates where none was measured.
Pose as_far_as_measured(const Machine& machine, const Reading& r) {
  Eigen::Vector3d pose = r.target.vector();
  for (int c = 0; c < machine.kind->n_chains; ++c) {
    if (machine.measured[static_cast<std::size_t>(c)]) pose[c] = r.measured->vector()[c];
  }
  return Pose::from(pose);
}

/// Whether what is measured says where a drive stands: what is not moves it by less than 1 % of
/// itself (mm of drive a mm, or a rad).
std::array<bool, kChains> seen_drives(const NominalMachine& machine) {
  const auto J_V = machine.look(machine.machine().home).J_V;
  const Eigen::Matrix3d dq_dX = inverse(machine.invertible(J_V));
  std::array<bool, kChains> seen = {};
  for (std::size_t i = 0; i < kChains; ++i) {
    seen[i] = static_cast<int>(i) < machine.machine().kind->n_chains;
    for (std::size_t c = 0; c < static_cast<std::size_t>(machine.machine().kind->n_chains); ++c) {
      const bool follows = std::abs(dq_dX(static_cast<int>(i), static_cast<int>(c))) > kFollows;
      seen[i] = seen[i] && (machine.machine().measured[c] || !follows);
    }
  }
  return seen;
}

int least_runs(const std::vector<RailTarget>& targets, bool up) {
  std::size_t least = SIZE_MAX;
  for (const RailTarget& t : targets) least = std::min(least, (up ? t.up : t.down).size());
  return static_cast<int>(least);
}

const std::vector<std::string> kNames = {"B",   "Bm", "R_u", "R_d", "R",   "E_u",
                                         "E_d", "E",  "M",   "A_u", "A_d", "A"};

void refuse(Iso230& out, const std::string& name, const std::string& reason) {
  out.symbols.push_back(
      {.name = name, .is_angle = false, .value = {}, .floor = {}, .reason = reason});
}

/// Why these targets can't carry any symbol; empty when they can.
std::string too_few(const Iso230& out, int runs) {
  const int needed =
      std::max(kLeastTargets, static_cast<int>(std::ceil(kLeastTargets * out.travel_mm / 1000)));
  std::string why;
  if (out.n_targets < needed) {
    why = "needs " + std::to_string(needed) + " targets or more, " + std::to_string(out.n_targets) +
          " here";
  }
  if (runs < kLeastRuns) {
    why += (why.empty() ? "needs " : "; ") + std::to_string(kLeastRuns) +
           " runs or more at every target, " + std::to_string(runs) + " here";
  }
  return why;
}

/// "over 2 homings: …; the visits drift by …"
std::string reserve_of(const RailTargets& rail) {
  std::vector<std::vector<double>> series;
  for (const RailTarget& t : rail.targets) {
    series.push_back(t.up);
    series.push_back(t.down);
  }
  const std::string drift = drift_words(series);
  if (rail.n_epochs < 2) return drift;
  return "over " + std::to_string(rail.n_epochs) + " homings: their scatter is in it" +
         (drift.empty() ? "" : "; " + drift);
}

Iso230 judged(const RailTargets& rail) {
  Iso230 out;
  out.rail = rail.rail;
  out.n_targets = static_cast<int>(rail.targets.size());
  out.travel_mm = rail.targets.back().position_mm - rail.targets.front().position_mm;
  const int runs_up = least_runs(rail.targets, true), runs_down = least_runs(rail.targets, false);
  const bool any_up = std::ranges::any_of(rail.targets, [](auto& t) { return !t.up.empty(); });
  const bool any_down = std::ranges::any_of(rail.targets, [](auto& t) { return !t.down.empty(); });
  out.least_runs = any_up && any_down ? std::min(runs_up, runs_down) : any_up ? runs_up : runs_down;
  const std::string why_up = any_up ? too_few(out, runs_up) : "no target was approached upwards";
  const std::string why_down =
      any_down ? too_few(out, runs_down) : "no target was approached downwards";
  const std::string reserve = reserve_of(rail);
  for (const RailTarget& target : rail.targets) out.reversals.push_back(reversal_at(target));
  std::map<std::string, double> value;
  if (why_up.empty()) {
    const OneWay u = iso230_one_way(rail.targets, true);
    value.insert({{"R_u", u.R_mm}, {"E_u", u.E_mm}, {"A_u", u.A_mm}});
  }
  if (why_down.empty()) {
    const OneWay d = iso230_one_way(rail.targets, false);
    value.insert({{"R_d", d.R_mm}, {"E_d", d.E_mm}, {"A_d", d.A_mm}});
  }
  if (why_up.empty() && why_down.empty()) {
    const BothWays b = iso230_both_ways(rail.targets);
    value.insert({{"B", b.B_mm},
                  {"Bm", b.Bm_mm},
                  {"R", b.R_mm},
                  {"E", b.E_mm},
                  {"M", b.M_mm},
                  {"A", b.A_mm}});
  }
  for (const std::string& name : kNames) {
    const auto at = value.find(name);
    if (at == value.end()) {
      const bool down = name.ends_with("_d"), up = name.ends_with("_u");
      refuse(out, name, down || (!up && why_up.empty()) ? why_down : why_up);
      continue;
    }
    out.symbols.push_back({name, false, at->second, {}, reserve});
  }
  return out;
}

}  // namespace

OneWay iso230_one_way(std::span<const RailTarget> targets, bool up) {
  OneWay out;
  Range means, bands;
  for (const RailTarget& t : targets) {
    const Runs r = runs_of(up ? t.up : t.down);
    out.R_mm = std::max(out.R_mm, 4 * r.s);
    means.add(r.mean);
    bands.add(r.mean + 2 * r.s);
    bands.add(r.mean - 2 * r.s);
  }
  out.E_mm = means.width();
  out.A_mm = bands.width();
  return out;
}

BothWays iso230_both_ways(std::span<const RailTarget> targets) {
  BothWays out;
  Range means, middles, bands;
  double sum = 0;
  for (const RailTarget& t : targets) {
    const Runs u = runs_of(t.up), d = runs_of(t.down);
    const double B = u.mean - d.mean;
    sum += B;
    out.B_mm = std::max(out.B_mm, std::abs(B));
    out.R_mm = std::max({out.R_mm, 2 * u.s + 2 * d.s + std::abs(B), 4 * u.s, 4 * d.s});
    middles.add((u.mean + d.mean) / 2);
    for (const Runs& r : {u, d}) {
      means.add(r.mean);
      bands.add(r.mean + 2 * r.s);
      bands.add(r.mean - 2 * r.s);
    }
  }
  out.Bm_mm = sum / static_cast<double>(targets.size());
  out.E_mm = means.width();
  out.M_mm = middles.width();
  out.A_mm = bands.width();
  return out;
}

Reversal reversal_at(const RailTarget& target) {
  Reversal out{.position_mm = target.position_mm,
               .n_up = static_cast<int>(target.up.size()),
               .n_down = static_cast<int>(target.down.size()),
               .s_up_mm = {},
               .s_down_mm = {},
               .fit = {}};
  if (out.n_up >= 2) out.s_up_mm = runs_of(target.up).s;
  if (out.n_down >= 2) out.s_down_mm = runs_of(target.down).s;
  if (out.n_up < 2 || out.n_down < 2) return out;
  double kk = 0, kx = 0, xx = 0;
  std::array<double, 2> mean = {};
  for (std::size_t way = 0; way < 2; ++way) {
    const std::vector<double>& x = way == 0 ? target.up : target.down;
    mean[way] = runs_of(x).mean;
    for (std::size_t k = 0; k < x.size(); ++k) {
      const double at = static_cast<double>(k) - (static_cast<double>(x.size()) - 1) / 2;
      kk += at * at;
      kx += at * (x[k] - mean[way]);
      xx += (x[k] - mean[way]) * (x[k] - mean[way]);
    }
  }
  const int free = out.n_up + out.n_down - 3;
  const double drift = kx / kk, s2 = std::max(0.0, xx - drift * kx) / free;
  out.fit = {mean[0] - mean[1], std::sqrt(s2 * (1.0 / out.n_up + 1.0 / out.n_down)), drift,
             std::sqrt(s2 / kk)};
  return out;
}

std::vector<RailTargets> rail_targets(const Machine& machine, std::span<const Reading> readings) {
  const NominalMachine solver(machine);
  const InverseResult home = solver.drives(machine.home);
  if (!home.ok()) throw InputError({.what = "the home pose is out of reach"});
  const std::array<bool, kChains> seen = seen_drives(solver);
  std::array<std::map<long long, RailTarget>, kChains> found;
  std::array<std::map<int, int>, kChains> epochs;
  int last = -1;
  for (const Reading& r : readings) {
    if (!r.measured) continue;
    const InverseResult wanted = solver.drives(r.target);
    if (!wanted.ok()) {
      last = -1;
      continue;
    }
    const int alone = rail_alone(wanted.l_mm - home.l_mm);
    const int rail = machine.kind->n_chains == 1 ? 0 : alone == kChains ? last : alone;
    last = rail;
    if (rail < 0 || !seen[static_cast<std::size_t>(rail)]) continue;
    const double move_mm = r.conditions.cmd_mm[rail] - r.conditions.from_mm[rail];
    if (std::abs(move_mm) <= kMovesMm) continue;
    const InverseResult attained = solver.drives(as_far_as_measured(machine, r));
    if (!attained.ok()) {
      throw InputError({.what = "a measured pose is out of nominal reach",
                        .where = {.point = "seq " + std::to_string(r.seq)}});
    }
    const auto i = static_cast<std::size_t>(rail);
    RailTarget& target = found[i][std::llround(wanted.l_mm[rail] / kAloneMm)];
    target.position_mm = wanted.l_mm[rail];
    (move_mm > 0 ? target.up : target.down).push_back(attained.l_mm[rail] - wanted.l_mm[rail]);
    ++epochs[i][r.conditions.epoch];
  }
  std::vector<RailTargets> rails;
  for (std::size_t i = 0; i < kChains; ++i) {
    if (found[i].size() < 2) continue;
    RailTargets rail{static_cast<int>(i) + 1, static_cast<int>(epochs[i].size()), {}};
    for (auto& [cell, target] : found[i]) rail.targets.push_back(std::move(target));
    rails.push_back(std::move(rail));
  }
  return rails;
}

std::vector<Iso230> iso230(const Machine& machine, std::span<const Reading> readings,
                           const std::optional<TrackerSigma>& sigma) {
  std::vector<Iso230> all;
  for (const RailTargets& rail : rail_targets(machine, readings)) all.push_back(judged(rail));
  if (sigma) {
    std::vector<IsoSymbol*> symbols;
    for (Iso230& rail : all) {
      for (IsoSymbol& symbol : rail.symbols) symbols.push_back(&symbol);
    }
    add_floors(symbols, readings, *sigma, [&](std::span<const Reading> perfect) {
      std::vector<IsoSymbol> found;
      for (Iso230& rail : iso230(machine, perfect))
        std::ranges::move(rail.symbols, std::back_inserter(found));
      return found;
    });
  }
  if (all.empty()) {
    Iso230 none;
    for (const std::string& name : kNames) {
      refuse(none, name, "no drive was measured alone: plan it with `trammel plan create rail`");
    }
    all.push_back(std::move(none));
  }
  return all;
}

}  // namespace trammel
