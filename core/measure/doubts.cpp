#include "core/measure/doubts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <tuple>

#include "core/measure/bad_readings.hpp"
#include "core/measure/noise.hpp"
#include "core/measure/printed.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/statistics/robust.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kOnTargetMm = 1e-6;     // measured equals target: no tracker comes so near
constexpr int kFewNominal = 3;           // fewer may be a coincidence nobody counted
constexpr double kNoChance = 0.01;       // readings of a campaign, by noise
constexpr double kOftenByChance = 0.1;   // coarse digits: half of a set may well stand on target
constexpr double kRoundMm = 0.1;         // instruments print finer
constexpr std::size_t kFewestRound = 6;  // poses that are round by chance: 10^-12
constexpr double kCoarseStep = 10;       // of sigma
constexpr int kEnoughFreedom = 12;
// Residuals of a smooth field are an upper bound of the noise: chi^2 of 12 degrees stays above
// 12/16 but for 1 in 10^5, and the quantile that stands for it is half as sure.
constexpr double kTooGood = 0.25;
constexpr double kTooBad = 10;     // repeats beyond the statement by a factor of units
constexpr double kWithinUnit = 3;  // a ratio so near to a unit's is that unit
constexpr double kArmMm = 100;     // of a platform
// At that arm turning errors are 0.14 to 1.1 times those of place on 3-PRR robots of 12 kinds of
// errors, and 57 times smaller once they are radians.
constexpr double kTurnsWithPlace = 0.05;
constexpr double kRadPerDeg = rad_from_deg(1);
constexpr double kKelvinAbove = 150;     // no machine is that hot: room temperature is 293 K
constexpr double kFahrenheitAbove = 50;  // 68 F is 20 deg C
constexpr double kWarmDegc = 5;          // an exact zero among such is no reading
constexpr int kEnoughSteps = 10;         // of time: fewer may be pauses
constexpr double kLongStepS = 3000;      // a point takes seconds to minutes: in ms 3 s are as many
constexpr double kShortStepS = 0.05;     // no machine moves, settles and is measured in less
constexpr std::size_t kFewestOfSet = 8;  // whose median means something
constexpr double kMoreThanBacklashMm = 0.5;
constexpr double kHardlyOverlap =
    3;  // scales: half way between, 7 % of each are nearer to the other
constexpr double kOneOrientation = rad_from_deg(0.05);  // orientations within it are one
constexpr double kFineStep = 0.3;                       // of sigma: coarser digits repeat by chance
constexpr double kFineStepMm = 1e-3;                    // where no sigma is known

bool knows(const std::vector<Suspicion>& found, Mistake kind) {
  return std::ranges::any_of(found, [kind](const Suspicion& s) { return s.kind == kind; });
}

/// The step of the decimal digits that x and y of poses are written with.
double digit_step_mm(const std::vector<Pose>& poses) {
  for (double step = 1; step > 1e-7; step /= 10) {
    const bool fits = std::ranges::all_of(poses, [step](const Pose& p) {
      const auto whole = [step](double v) {
        return std::abs(v / step - std::round(v / step)) < 1e-6 * std::max(1.0, std::abs(v / step));
      };
      return whole(p.x_mm) && whole(p.y_mm);
    });
    if (fits) return step;
  }
  return 0;
}

double digit_step_mm(const Campaign& c) {
  std::vector<Pose> measured;
  for (const Reading& r : c.readings)
    if (r.measured) measured.push_back(*r.measured);
  return digit_step_mm(measured);
}

/// Measured poses as round as a plan's where targets are not.
void add_round_poses(const Campaign& c, std::vector<Suspicion>& found) {
  if (!c.tracker) return;
  std::vector<Pose> targets;
  for (const Reading& r : c.readings)
    if (r.measured) targets.push_back(r.target);
  const double measured_mm = digit_step_mm(c), target_mm = digit_step_mm(targets);
  if (targets.size() < kFewestRound ||
      measured_mm < std::max(kRoundMm, kCoarseStep * c.tracker->xy_mm) ||
      target_mm * kCoarseStep > measured_mm)
    return;
  found.push_back(
      {Mistake::nominal, "have measured poses and targets changed places?",
       printed("measured x and y are whole numbers of %.3g mm, targets are not", measured_mm)});
}

/// How often noise puts a position to the last digit where another stands, at the most: densities
/// of a normal distribution at its middle.
double chance_of_one_digit(const Campaign& c, double step_mm) {
  const double sigma_mm = c.tracker ? c.tracker->xy_mm : kFineStepMm;
  const double one =
      std::min(1.0, std::max(step_mm, kOnTargetMm) / (std::sqrt(2 * kPi) * sigma_mm));
  const Coordinates& is_measured = c.machine.measured;
  return (is_measured[0] ? one : 1) * (is_measured[1] ? one : 1);
}

/// Positions that stand on their targets to the last digit they are written with: more than half of
/// a set, or a few where digits are so fine that chance leaves none.
void add_nominal(const Campaign& c, std::vector<Suspicion>& found) {
  const double step_mm = digit_step_mm(c);
  const double on_target_mm = step_mm <= kFineStepMm ? std::max(kOnTargetMm, step_mm) : kOnTargetMm;
  const double chance = chance_of_one_digit(c, step_mm);
  std::vector<int> same;
  std::map<ReadingSet, std::pair<int, int>> of_set;  // on target, measured
  for (const Reading& r : c.readings) {
    if (!r.measured) continue;
    auto& [on_target, measured] = of_set[r.set];
    ++measured;
    if (std::hypot(r.measured->x_mm - r.target.x_mm, r.measured->y_mm - r.target.y_mm) >=
        on_target_mm)
      continue;
    ++on_target;
    same.push_back(r.seq);
  }
  int all = 0;
  bool most_of_a_set = false;
  for (const auto& [set, count] : of_set) {
    all += count.second;
    most_of_a_set = most_of_a_set || (count.first >= kFewNominal && 2 * count.first > count.second);
  }
  // Digits far coarser than the noise are those of a plan, or of a reading that says nothing.
  const bool coarse = c.tracker && step_mm > kCoarseStep * c.tracker->xy_mm;
  const bool few = static_cast<int>(same.size()) >= kFewNominal && chance * all < kNoChance;
  if (!few && !(most_of_a_set && (coarse || chance < kOftenByChance))) return;
  found.push_back({Mistake::nominal, "measured equals target: were nominals exported?",
                   printed("%d of %d readings stand on their targets to %.2g mm, nearer than any "
                           "tracker reads",
                           static_cast<int>(same.size()), all, on_target_mm),
                   static_cast<int>(same.size()) == all ? std::vector<int>{} : same});
}

/// At one orientation, where deviations of orientations are by far smaller than those of positions
/// make likely: legs in error move and turn a platform alike.
bool turns_too_little(const Campaign& c) {
  double low = INFINITY, high = -INFINITY;
  std::vector<double> x, y, phi;
  for (const Reading& r : c.readings) {
    low = std::min(low, r.target.phi_rad);
    high = std::max(high, r.target.phi_rad);
    if (!r.measured) continue;
    x.push_back(r.measured->x_mm - r.target.x_mm);
    y.push_back(r.measured->y_mm - r.target.y_mm);
    phi.push_back(std::remainder(r.measured->phi_rad - r.target.phi_rad, 2 * kPi));
  }
  if (high - low >= kOneOrientation) return false;
  const auto scatter = [](std::vector<double>& values) {
    const double middle = median(values);
    for (double& v : values) v -= middle;
    return robust_sigma(values);
  };
  return scatter(phi) * kArmMm < kTurnsWithPlace * std::hypot(scatter(x), scatter(y));
}

/// Ratios of what scatters about a smooth field and what is stated; 1 for what is not measured.
struct Scatter {
  SmoothResidual left;
  double xy_mm = 0;  // per coordinate
  double xy = 1, phi = 1;
  bool judged = false;

  explicit Scatter(const Campaign& c) : left(smooth_residual(c)) {
    const Coordinates& is_measured = c.machine.measured;
    const int n_xy = (is_measured[0] ? 1 : 0) + (is_measured[1] ? 1 : 0);
    xy_mm = std::hypot(left.x_mm, left.y_mm) / std::sqrt(std::max(1, n_xy));
    if (n_xy > 0) xy = xy_mm / c.tracker->xy_mm;
    if (is_measured[2]) phi = left.phi_rad / c.tracker->phi_rad;
    judged = left.degrees_of_freedom >= kEnoughFreedom;
  }
};

bool near_unit(double ratio, double unit) {
  return ratio > unit / kWithinUnit && ratio < unit * kWithinUnit;
}

/// Orientations in radians where their scatter alone can tell; of `part`, empty: of all readings.
void add_radians(const Campaign& c, const Scatter& of, const std::string& part,
                 std::vector<Suspicion>& found) {
  if (!of.judged || of.xy < kTooGood || !near_unit(of.phi, kRadPerDeg) || !turns_too_little(c))
    return;
  std::vector<int> seqs;
  for (const Reading& r : c.readings) {
    if (!part.empty()) seqs.push_back(r.seq);
  }
  found.push_back(
      {Mistake::radians,
       part + printed("measured orientations are radians where degrees are due (slope %.4g)",
                      kRadPerDeg),
       printed("they scatter by %.2g deg, %.3g of the stated %.2g deg, while positions "
               "scatter as stated, and deviate by as little",
               deg_from_rad(of.left.phi_rad), of.phi, deg_from_rad(c.tracker->phi_rad)),
       seqs});
}

/// Of all, else of one set.
void add_radians(const Campaign& c, const Scatter& of, std::vector<Suspicion>& found) {
  add_radians(c, of, "", found);
  for (const auto& [set, words] :
       {std::pair(ReadingSet::identify, "of the identify readings alone: "),
        std::pair(ReadingSet::validate, "of the validation readings alone: ")}) {
    if (knows(found, Mistake::radians)) return;
    Campaign some = c;
    std::erase_if(some.readings, [set = set](const Reading& r) { return r.set != set; });
    if (some.readings.size() < c.readings.size()) add_radians(some, Scatter(some), words, found);
  }
}

/// Sigma by far larger than what scatters, or smaller than what repeats show.
void add_sigma(const Campaign& c, const Scatter& of, std::vector<Suspicion>& found) {
  const Coordinates& is_measured = c.machine.measured;
  const auto& [left, left_xy_mm, xy, phi, judged] = of;
  if (judged && (xy < kTooGood || phi < kTooGood)) {
    const bool is_xy = xy < kTooGood;
    const double ratio = is_xy ? xy : phi;
    found.push_back(
        {Mistake::sigma_unit,
         printed("is the stated sigma in the right unit%s? It is %.3g %s",
                 is_xy && near_unit(ratio, 1e-3) ? " (it looks like micrometres for mm)" : "",
                 is_xy ? c.tracker->xy_mm : deg_from_rad(c.tracker->phi_rad), is_xy ? "mm" : "deg"),
         printed("readings scatter about a smooth field by %.2g %s, %.2g of the stated noise",
                 is_xy ? left_xy_mm : deg_from_rad(left.phi_rad), is_xy ? "mm" : "deg", ratio)});
    return;
  }
  const char* small_xy = judged && near_unit(xy, 1e3) ? " (it looks like metres for mm)" : "";
  const char* small_phi =
      judged && near_unit(phi, deg_from_rad(1)) && near_unit(phi / xy, deg_from_rad(1))
          ? " (it looks like radians for deg)"
          : "";
  if (*small_xy != 0 || *small_phi != 0) {
    found.push_back(
        {Mistake::sigma_unit,
         printed("is the stated sigma in the right unit? It is %.3g mm%s and %.3g deg%s",
                 c.tracker->xy_mm, small_xy, deg_from_rad(c.tracker->phi_rad), small_phi),
         printed("readings scatter about a smooth field by %.2g mm and %.2g deg", left_xy_mm,
                 deg_from_rad(left.phi_rad))});
    return;
  }
  const auto repeats = pooled_noise(c.readings, is_measured);
  if (!repeats || repeats->degrees_of_freedom < kEnoughFreedom) return;
  if (!((is_measured[0] || is_measured[1]) && repeats->sigma.xy_mm >= kTooBad * c.tracker->xy_mm) &&
      !(is_measured[2] && repeats->sigma.phi_rad >= kTooBad * c.tracker->phi_rad))
    return;
  found.push_back({Mistake::sigma_unit,
                   printed("is the stated sigma in the right unit? It is %.3g mm and %.3g deg",
                           c.tracker->xy_mm, deg_from_rad(c.tracker->phi_rad)),
                   printed("repeats scatter by %.2g mm and %.2g deg", repeats->sigma.xy_mm,
                           deg_from_rad(repeats->sigma.phi_rad))});
}

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

/// Readings of one target with the same pose to the last digit, where digits are finer than noise.
void add_copies(const Campaign& c, std::vector<Suspicion>& found) {
  const double fine_mm = c.tracker ? kFineStep * c.tracker->xy_mm : kFineStepMm;
  const double step_mm = digit_step_mm(c);
  if (step_mm > fine_mm) return;
  using Key = std::tuple<double, double, double>;
  std::map<Key, std::vector<const Reading*>> groups;
  for (const Reading& r : c.readings) {
    if (r.measured) groups[{r.measured->x_mm, r.measured->y_mm, r.measured->phi_rad}].push_back(&r);
  }
  if (std::ranges::count(c.machine.measured, true) < 2) {  // one number repeats by chance
    std::map<std::tuple<double, double, double>, double> of_target;
    for (const Reading& r : c.readings)
      if (r.measured) ++of_target[{r.target.x_mm, r.target.y_mm, r.target.phi_rad}];
    double pairs = 0;
    for (const auto& [target, n] : of_target) pairs += n * (n - 1) / 2;
    if (pairs * chance_of_one_digit(c, step_mm) / std::sqrt(2.0) > kNoChance) return;
  }
  std::vector<int> copied, duplicated;
  const auto validates = [](const Reading* r) { return r->set == ReadingSet::validate; };
  for (const auto& [key, rows] : groups) {
    const Pose& target = rows.front()->target;
    const bool fitted = !std::ranges::all_of(rows, validates);
    for (std::size_t k = fitted && validates(rows.front()) ? 0 : 1; k < rows.size(); ++k) {
      if (!(rows[k]->target == target)) continue;
      (fitted && validates(rows[k]) ? copied : duplicated).push_back(rows[k]->seq);
    }
  }
  std::ranges::sort(copied);
  std::ranges::sort(duplicated);
  if (!copied.empty()) {
    found.push_back({Mistake::copied,
                     printed("%d validation readings are copies of fitted ones: none of them is "
                             "unseen",
                             static_cast<int>(copied.size())),
                     "target and measured pose are the same to the last digit", copied});
  }
  if (!duplicated.empty()) {
    found.push_back(
        {Mistake::duplicated,
         printed("%d readings stand more than once", static_cast<int>(duplicated.size())),
         "target and measured pose are the same to the last digit", duplicated});
  }
}

void add_epochs(const Campaign& c, std::vector<Suspicion>& found) {
  std::set<int> fitted;
  std::vector<int> unseen;
  int epoch = 0;
  for (const Reading& r : c.readings) {
    if (r.set == ReadingSet::identify && r.measured) fitted.insert(r.conditions.epoch);
  }
  for (const Reading& r : c.readings) {
    if (r.set != ReadingSet::validate || fitted.contains(r.conditions.epoch)) continue;
    unseen.push_back(r.seq);
    epoch = r.conditions.epoch;
  }
  if (unseen.empty() || fitted.empty()) return;
  found.push_back({Mistake::unknown_epoch,
                   printed("the frame and homing of epoch %d are unknown: its validation readings "
                           "judge nothing",
                           epoch),
                   printed("%d validation readings are of an epoch in which no reading is fitted",
                           static_cast<int>(unseen.size())),
                   unseen});
}

void add_commands(const Campaign& c, std::vector<Suspicion>& found) {
  const std::vector<double> off_mm = command_off_mm(c);
  std::vector<int> others;
  double most_mm = 0;
  for (std::size_t k = 0; k < off_mm.size(); ++k) {
    if (off_mm[k] <= kNominalCommandMm || single_far_command(off_mm, k)) continue;
    others.push_back(c.readings[k].seq);
    most_mm = std::max(most_mm, off_mm[k]);
  }
  if (others.empty()) return;
  const bool all = others.size() == c.readings.size();
  found.push_back(
      {Mistake::other_commands,
       all ? "all commands are of another model than the nominal one"
           : printed("%d of %d readings were measured under a correction",
                     static_cast<int>(others.size()), static_cast<int>(c.readings.size())),
       printed("they differ from the nominal inverse kinematics of their targets by up "
               "to %.3g mm",
               most_mm),
       all ? std::vector<int>{} : others});
}

/// Sets of one epoch whose deviations hardly overlap, and are farther apart than any backlash.
void add_moved_frame(const Campaign& c, std::vector<Suspicion>& found) {
  std::map<int, std::array<std::array<std::vector<double>, 3>, 2>> of_epoch;  // mm, phi at an arm
  for (const Reading& r : c.readings) {
    if (!r.measured || r.set == ReadingSet::predict) continue;
    auto& off = of_epoch[r.conditions.epoch][r.set == ReadingSet::validate ? 1 : 0];
    off[0].push_back(r.measured->x_mm - r.target.x_mm);
    off[1].push_back(r.measured->y_mm - r.target.y_mm);
    off[2].push_back(kArmMm * std::remainder(r.measured->phi_rad - r.target.phi_rad, 2 * kPi));
  }
  for (auto& [epoch, sets] : of_epoch) {
    if (std::min(sets[0][0].size(), sets[1][0].size()) < kFewestOfSet) continue;
    std::array<double, 3> apart_mm = {};
    bool is_apart = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<double, 2> middle = {}, scatter = {};
      for (std::size_t set = 0; set < 2; ++set) {
        std::vector<double>& off = sets[set][axis];
        middle[set] = median(off);
        for (double& v : off) v -= middle[set];
        scatter[set] = robust_sigma(off);
      }
      apart_mm[axis] = middle[1] - middle[0];
      is_apart = is_apart || std::abs(apart_mm[axis]) >
                                 std::max(kMoreThanBacklashMm,
                                          kHardlyOverlap * std::max(scatter[0], scatter[1]));
    }
    if (!is_apart) continue;
    std::vector<int> seqs;
    for (const Reading& r : c.readings) {
      if (r.measured && r.set == ReadingSet::validate && r.conditions.epoch == epoch)
        seqs.push_back(r.seq);
    }
    found.push_back({Mistake::moved_frame,
                     printed("have frame or homing changed before the validation readings of epoch "
                             "%d?",
                             epoch),
                     printed("they are (%.3g, %.3g) mm and %.2g deg farther off their targets than "
                             "the fitted ones",
                             apart_mm[0], apart_mm[1], deg_from_rad(apart_mm[2] / kArmMm)),
                     seqs});
  }
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

std::vector<double> command_off_mm(const Campaign& c) {
  const MachineSolver solver(c.machine);
  std::vector<double> off_mm;
  for (const Reading& r : c.readings) {
    const InverseResult at = solver.drives(r.target);
    off_mm.push_back(at.ok() ? (r.conditions.cmd_mm - at.l_mm).cwiseAbs().maxCoeff() : 0);
  }
  return off_mm;
}

bool single_far_command(const std::vector<double>& off_mm, std::size_t reading) {
  const auto is_far = [](double mm) { return mm > kMostCorrectionMm; };
  return is_far(off_mm[reading]) && 2 * std::ranges::count_if(off_mm, is_far) < std::ssize(off_mm);
}

std::vector<std::size_t> under_a_correction(const Campaign& c) {
  const std::vector<double> off_mm = command_off_mm(c);
  const auto is_other = [](double off) { return off > kNominalCommandMm; };
  std::vector<std::size_t> corrected;
  if (std::ranges::all_of(off_mm, is_other)) return corrected;
  for (std::size_t k = 0; k < off_mm.size(); ++k) {
    if (is_other(off_mm[k]) && off_mm[k] < kMostCorrectionMm) corrected.push_back(k);
  }
  return corrected;
}

std::vector<Suspicion> doubts(const Campaign& c, const std::vector<Suspicion>& known) {
  std::vector<Suspicion> found;
  if (!is_gross(known)) {
    add_nominal(c, found);
    if (found.empty()) add_round_poses(c, found);
    if (!knows(found, Mistake::nominal)) {
      if (c.tracker) {
        const Scatter of(c);
        add_radians(c, of, found);
        if (!is_gross(found)) add_sigma(c, of, found);
      }
      add_copies(c, found);
    }
    add_epochs(c, found);
    add_moved_frame(c, found);
    add_commands(c, found);
  }
  add_temperature(c, found);
  add_clock(c, found);
  add_missing(
      c, "temp_degc", [](const Reading& r) { return r.conditions.temp_degc.has_value(); }, found);
  add_missing(
      c, "time_s", [](const Reading& r) { return r.conditions.time_s.has_value(); }, found);
  return found;
}

}  // namespace trammel
