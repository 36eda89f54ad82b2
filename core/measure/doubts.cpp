#include "core/measure/doubts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/measure/doubt_kinds.hpp"
#include "core/measure/lie.hpp"
#include "core/measure/nominal_commands.hpp"
#include "core/measure/printed.hpp"
#include "core/statistics/robust.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr std::size_t kFewestOfSet = 8;      // whose median means something
constexpr double kMoreThanBacklashMm = 0.5;  // and orientations at an arm of 100 mm
constexpr double kHardlyOverlap = 3;  // scales: half way, 7 % of each are nearer to the other

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
    off[2].push_back(poses::kArmMm *
                     std::remainder(r.measured->phi_rad - r.target.phi_rad, 2 * kPi));
  }
  for (auto& [epoch, sets] : of_epoch) {
    if (std::min(sets[0][0].size(), sets[1][0].size()) < kFewestOfSet) continue;
    std::array<double, 3> apart_mm = {};
    bool is_apart = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto &fitted = sets[0][axis], &judging = sets[1][axis];
      apart_mm[axis] = median(judging) - median(fitted);
      const double scatter_mm = std::max(robust_scatter(fitted), robust_scatter(judging));
      is_apart = is_apart || std::abs(apart_mm[axis]) >
                                 std::max(kMoreThanBacklashMm, kHardlyOverlap * scatter_mm);
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
                             apart_mm[0], apart_mm[1], deg_from_rad(apart_mm[2] / poses::kArmMm)),
                     seqs});
  }
}

}  // namespace

std::vector<Suspicion> doubts(const Campaign& c, const std::vector<Suspicion>& known) {
  std::vector<Suspicion> found;
  if (!is_gross(known)) {
    if (!add_doubts_of_digits(c, found)) {
      add_doubts_of_sigma(c, found);
      add_doubts_of_copies(c, found);
    }
    add_epochs(c, found);
    add_moved_frame(c, found);
    add_commands(c, found);
  }
  add_doubts_of_cells(c, found);
  return found;
}

}  // namespace trammel
