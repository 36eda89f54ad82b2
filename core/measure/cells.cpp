// Times and temperatures: units, clocks that run backwards, cells that are empty.

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/measure/doubt_kinds.hpp"
#include "core/measure/printed.hpp"
#include "core/statistics/robust.hpp"

namespace trammel {

namespace {

constexpr double kKelvinAbove = 150;     // no machine is that hot: room temperature is 293 K
constexpr double kFahrenheitAbove = 50;  // 68 F is 20 deg C
constexpr double kWarmDegc = 5;          // an exact zero among such is no reading
constexpr int kEnoughSteps = 10;         // of time: fewer may be pauses
constexpr double kLongStepS = 3000;      // a point takes seconds to minutes: in ms 3 s are as many
constexpr double kShortStepS = 0.05;     // no machine moves, settles and is measured in less

/// Exactly 0 deg C where the others are warm, or everywhere: a cell that was filled up.
void add_zero_temperatures(const Campaign& c, std::vector<Suspicion>& found) {
  std::vector<int> zero;
  std::vector<double> others;
  for (const Reading& r : c.readings) {
    if (!r.conditions.temp_degc) continue;
    if (*r.conditions.temp_degc == 0)
      zero.push_back(r.seq);
    else
      others.push_back(*r.conditions.temp_degc);
  }
  if (zero.size() < (others.empty() ? 2U : 1U)) return;
  if (!others.empty() && std::abs(median(others)) < kWarmDegc) return;
  const auto n = static_cast<int>(zero.size());
  if (others.empty()) zero.clear();
  found.push_back(
      {Mistake::temperature_unit, "does 0 deg C stand for a temperature nobody read?",
       others.empty() ? printed("all %d temperatures are exactly 0", n)
                      : printed("%d are exactly 0, the others about %.3g deg C", n, median(others)),
       zero});
}

void add_temperature(const Campaign& c, std::vector<Suspicion>& found) {
  std::vector<int> kelvin, fahrenheit;
  double one_k = 0, one_f = 0;
  std::size_t all = 0;
  for (const Reading& r : c.readings) {
    if (!r.conditions.temp_degc) continue;
    ++all;
    const double t = *r.conditions.temp_degc;
    if (t > kKelvinAbove) {
      kelvin.push_back(r.seq);
      one_k = t;
    } else if (t > kFahrenheitAbove) {
      fahrenheit.push_back(r.seq);
      one_f = t;
    }
  }
  const auto add = [&](std::vector<int> seqs, double one, const char* unit, double degc) {
    if (seqs.empty()) return;
    if (seqs.size() == all) seqs.clear();
    found.push_back(
        {Mistake::temperature_unit, printed("are temperatures in %s where deg C are due?", unit),
         printed("temp_degc is %.4g, which would be %.3g deg C", one, degc), std::move(seqs)});
  };
  add_zero_temperatures(c, found);
  add(kelvin, one_k, "kelvin", one_k - 273.15);
  add(fahrenheit, one_f, "degrees Fahrenheit", (one_f - 32) / 1.8);
}

/// Steps of time that no machine takes, or none at all.
void add_time_unit(const Campaign& c, std::vector<Suspicion>& found) {
  std::vector<double> steps_s;
  std::vector<int> after_long;
  const Reading* before = nullptr;
  for (const Reading& r : c.readings) {
    if (!r.conditions.time_s) continue;
    if (before) {
      steps_s.push_back(*r.conditions.time_s - *before->conditions.time_s);
      if (steps_s.back() > kLongStepS) after_long.push_back(r.seq);
    }
    before = &r;
  }
  if (steps_s.size() < static_cast<std::size_t>(kEnoughSteps)) return;
  const double step_s = median(steps_s);
  const bool many = after_long.size() >= static_cast<std::size_t>(kEnoughSteps) &&
                    4 * after_long.size() > steps_s.size();
  if (std::ranges::all_of(steps_s, [](double s) { return s == 0; })) {
    found.push_back({Mistake::clock, "all readings have one time",
                     printed("time_s is %.10g throughout", *before->conditions.time_s)});
  } else if (many) {
    const bool all = after_long.size() == steps_s.size();
    found.push_back({Mistake::clock, "are times in milliseconds where seconds are due?",
                     printed("from reading to reading time_s grows by more than %.4g s, which is "
                             "%.3g h, %d times",
                             kLongStepS, kLongStepS / 3600, static_cast<int>(after_long.size())),
                     all ? std::vector<int>{} : after_long});
  } else if (step_s > 0 && step_s < kShortStepS) {
    found.push_back({Mistake::clock, "are times in days or hours where seconds are due?",
                     printed("from reading to reading time_s grows by %.2g s; %.3g s in days and "
                             "%.3g s in hours",
                             step_s, step_s * 86400, step_s * 3600)});
  }
}

void add_clock(const Campaign& c, std::vector<Suspicion>& found) {
  add_time_unit(c, found);
  const Reading* before = nullptr;
  std::vector<int> back;
  std::string first;
  for (const Reading& r : c.readings) {
    if (!r.conditions.time_s) continue;
    if (before && *r.conditions.time_s < *before->conditions.time_s) {
      if (back.empty()) {
        first = printed("from %.10g s at seq %d to %.10g s at seq %d, by %.10g s",
                        *before->conditions.time_s, before->seq, *r.conditions.time_s, r.seq,
                        *before->conditions.time_s - *r.conditions.time_s);
      }
      back.push_back(r.seq);
    }
    before = &r;
  }
  if (back.empty()) return;
  const std::string times = back.size() == 1 ? "once" : std::to_string(back.size()) + " times";
  found.push_back({Mistake::clock, "time runs backwards " + times,
                   (back.size() == 1 ? "" : "first ") + first, back});
}
void add_missing(const Campaign& c, const char* cell,
                 const std::function<bool(const Reading&)>& has, std::vector<Suspicion>& found) {
  std::vector<int> without;
  for (const Reading& r : c.readings) {
    if (!has(r)) without.push_back(r.seq);
  }
  if (without.empty() || without.size() == c.readings.size()) return;
  found.push_back({Mistake::missing_cells,
                   printed("%d of %d readings have no %s", static_cast<int>(without.size()),
                           static_cast<int>(c.readings.size()), cell),
                   "their cells are empty", without});
}

}  // namespace

void add_doubts_of_cells(const Campaign& c, std::vector<Suspicion>& found) {
  add_temperature(c, found);
  add_clock(c, found);
  add_missing(
      c, "temp_degc", [](const Reading& r) { return r.conditions.temp_degc.has_value(); }, found);
  add_missing(
      c, "time_s", [](const Reading& r) { return r.conditions.time_s.has_value(); }, found);
}

}  // namespace trammel
