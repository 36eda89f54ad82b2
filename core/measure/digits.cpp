// What the digits of poses say: nominals, columns that changed places, copies.

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/measure/doubt_kinds.hpp"
#include "core/measure/printed.hpp"
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
constexpr double kFineStep = 0.3;        // of sigma: coarser digits repeat by chance
constexpr double kFineStepMm = 1e-3;     // where no sigma is known

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

}  // namespace

bool add_doubts_of_digits(const Campaign& c, std::vector<Suspicion>& found) {
  const std::size_t known = found.size();
  add_nominal(c, found);
  if (found.size() == known) add_round_poses(c, found);
  return found.size() > known;
}

void add_doubts_of_copies(const Campaign& c, std::vector<Suspicion>& found) {
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

}  // namespace trammel
