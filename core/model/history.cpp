#include "core/model/history.hpp"

#include <algorithm>
#include <cmath>

#include "core/mechanism/machine_solver.hpp"

namespace trammel {

namespace {

constexpr double kShortestLagS = 30;

std::vector<double> key_of(const Conditions& c) {
  std::vector<double> key = {static_cast<double>(c.epoch), c.time_s.value_or(-1)};
  key.insert(key.end(), c.cmd_mm.begin(), c.cmd_mm.end());
  key.insert(key.end(), c.from_mm.begin(), c.from_mm.end());
  return key;
}

/// F of the play operator of a radius after a reading's last move.
void follow(Displacements& F, const Conditions& c, double radius_mm) {
  for (const Displacements& l : {c.from_mm, c.cmd_mm}) {
    F = (l.array() - radius_mm).max((l.array() + radius_mm).min(F.array())).matrix();
  }
}

}  // namespace

double History::lag_s(int place) { return kShortestLagS * std::exp2(0.5 * place); }

History::History(const Machine& machine, std::vector<Reading> path)
    : home_mm_(drives_of(machine, machine.home)) {
  std::ranges::stable_sort(path, {}, &Reading::seq);
  std::map<int, Plays> of_epoch;
  for (const Reading& r : path) {
    const auto [at, first] = of_epoch.try_emplace(r.conditions.epoch);
    if (first) at->second.fill(home_mm_);
    for (std::size_t k = 0; k < kRadiiMm.size(); ++k) {
      follow(at->second[k], r.conditions, kRadiiMm[k]);
    }
    plays_[key_of(r.conditions)] = at->second;
  }
  std::erase_if(path,
                [](const Reading& r) { return !r.conditions.time_s || !r.conditions.temp_degc; });
  std::ranges::stable_sort(path, {}, [](const Reading& r) { return *r.conditions.time_s; });
  for (const Reading& r : path) {
    Record now{*r.conditions.time_s, *r.conditions.temp_degc, {}};
    now.late_degc.fill(now.temp_degc);
    for (int k = 0; k < kLags && !records_.empty(); ++k) {
      now.late_degc[static_cast<std::size_t>(k)] = behind(records_.back(), r.conditions, k);
    }
    records_.push_back(now);
  }
}

Displacements History::taken(const Conditions& at, double least_mm, double largest_mm) const {
  const auto on_path = plays_.find(key_of(at));
  Displacements sum = Displacements::Zero();
  double radii = 0;
  for (std::size_t k = 0; k < kRadiiMm.size(); ++k) {
    if (kRadiiMm[k] < least_mm || kRadiiMm[k] > largest_mm) continue;
    Displacements F = home_mm_;
    if (on_path != plays_.end()) {
      F = on_path->second[k];
    } else {
      follow(F, at, kRadiiMm[k]);
    }
    sum += (at.cmd_mm - F) / kRadiiMm[k];
    ++radii;
  }
  return radii > 0 ? Displacements(sum / radii) : sum;
}

double History::behind(const Record& last, const Conditions& at, int lag) const {
  const double dt = *at.time_s - last.time_s, F = last.late_degc[static_cast<std::size_t>(lag)];
  if (dt <= 0) return F;
  const double tau = lag_s(lag);
  const double ramp = (*at.temp_degc - last.temp_degc) / dt * tau;  // in the long run F lags by it
  return *at.temp_degc - ramp + (F - last.temp_degc + ramp) * std::exp(-dt / tau);
}

double History::late_degc(const Conditions& at, double tau_s) const {
  const auto after = std::ranges::upper_bound(records_, *at.time_s, {}, &Record::time_s);
  if (after == records_.begin()) return *at.temp_degc;
  const double place =
      std::clamp(2 * std::log2(tau_s / kShortestLagS), 0.0, static_cast<double>(kLags - 1));
  const int first = std::clamp(static_cast<int>(place) - 1, 0, kLags - 4);
  double sum = 0;  // Lagrange's polynomial through four lags
  for (int k = first; k < first + 4; ++k) {
    double weight = 1;
    for (int j = first; j < first + 4; ++j) {
      if (j != k) weight *= (place - j) / (k - j);
    }
    sum += weight * behind(*(after - 1), at, k);
  }
  return sum;
}

double History::delayed_degc(const Conditions& at, double delay_s) const {
  const double time_s = *at.time_s - delay_s;
  const auto after = std::ranges::upper_bound(records_, time_s, {}, &Record::time_s);
  if (records_.empty()) return *at.temp_degc;
  if (after == records_.begin()) return after->temp_degc;
  const Record& before = *(after - 1);
  if (after == records_.end()) return before.temp_degc;
  const double share = (time_s - before.time_s) / (after->time_s - before.time_s);
  return before.temp_degc + share * (after->temp_degc - before.temp_degc);
}

}  // namespace trammel
