#include "core/measure/epochs.hpp"
#include "core/measure/held_epochs.hpp"

#include <cmath>

#include "core/mechanism/forward.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/plan/grids.hpp"
#include "core/simulate/virtual_robot.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// The paper's star, measured in its order by a robot of the paper's kind of errors, set up anew
/// before reading `from` with `frame` as its new frame.
std::vector<Reading> campaign(std::uint64_t seed, int from, const Pose& frame) {
  Random random(seed);
  simulate::Truth truth;
  truth.nominal = machine_of(paper_mechanism());
  truth.actual = truth.nominal.chains;
  truth.seed = seed;
  truth.tracker.sigma_xy_mm = 0.010;
  truth.tracker.sigma_phi_rad = rad_from_deg(0.004);
  for (int i = 0; i < kChains; ++i) {
    truth.drive.lead_scale[i] = 4e-3 * random.normal();
    truth.drive.backlash_mm[i] = std::abs(0.05 * random.normal());
  }
  truth.epochs.resize(2);
  truth.epochs[1].frame = frame;
  const simulate::VirtualRobot robot(truth);
  std::vector<Reading> readings;
  Displacements at = robot.home_mm();
  for (const Pose& target : paper_80()) {
    Reading r;
    r.seq = static_cast<int>(readings.size()) + 1;
    r.target = target;
    r.conditions.cmd_mm = inverse(paper_mechanism().geometry, target).l_mm;
    r.conditions.from_mm = at;
    r.conditions.epoch = r.seq < from ? 1 : 2;
    r.measured = robot.read(r.conditions, static_cast<std::uint64_t>(r.seq)).pose;
    at = r.conditions.cmd_mm;
    readings.push_back(r);
  }
  return readings;
}

}  // namespace

TEST_CASE("an epoch whose references hold is no step, one that moved by 0.05 mm is", "[measure]") {
  // 100 robots, each set up anew somewhere: level 1 %, so more than 5 alarms in 0.05 % of runs.
  int alarms = 0, found = 0;
  Random random(7);
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const int from = static_cast<int>(random.uniform(10, 72));
    const Mechanism mechanism = paper_mechanism();
    alarms += test_epochs(mechanism, campaign(seed, from, {})).hold ? 0 : 1;
    found += test_epochs(mechanism, campaign(seed, from, {0.05, -0.03, 0})).hold ? 0 : 1;
  }
  INFO(alarms << " alarms, " << found << " found");
  CHECK(alarms <= 5);
  CHECK(found >= 95);
}

TEST_CASE("epochs between which references held are one set-up, unless readings show a step",
          "[measure]") {
  // 100 robots in four epochs each, of which references tie all but the second to the one before:
  // at 1 in 10,000 and two groups an alarm in 2 % of runs.
  const Mechanism mechanism = paper_mechanism();
  const std::vector<std::pair<int, int>> held = {{2, 3}, {3, 4}, {6, 7}};
  int alarms = 0, found = 0;
  Random random(8);
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Pose frame{0.3, -0.2, rad_from_deg(0.05)};
    std::vector<Reading> readings = campaign(seed, 21, frame);
    const int third = static_cast<int>(random.uniform(25, 50));
    for (Reading& r : readings) {
      if (r.seq >= third) r.conditions.epoch = 3;
      if (r.seq >= 65) r.conditions.epoch = 4;
    }
    const auto one = epochs_of_one_set_up(mechanism, readings, held);
    alarms += one == std::map<int, int>{{3, 2}, {4, 2}, {7, 6}} ? 0 : 1;
    for (Reading& r : readings) {
      if (r.conditions.epoch == 3) r.measured = in_frame({0.2, 0.1, 0}, *r.measured);
    }
    found += epochs_of_one_set_up(mechanism, readings, held) == std::map<int, int>{{7, 6}} ? 1 : 0;
  }
  INFO(alarms << " alarms, " << found << " found");
  CHECK(alarms <= 1);
  CHECK(found >= 95);
}

TEST_CASE("one epoch, and too few readings, are no answer", "[measure]") {
  std::vector<Reading> readings = campaign(1, 41, {});
  CHECK_FALSE(test_epochs(paper_mechanism(), std::span(readings).first(30)).tested);
  CHECK(test_epochs(paper_mechanism(), std::span(readings).first(30)).later_epochs == 0);
  readings.erase(readings.begin(), readings.begin() + 34);
  readings.resize(12);
  const EpochTest few = test_epochs(paper_mechanism(), readings);
  CHECK(few.later_epochs == 1);
  CHECK_FALSE(few.tested);
  CHECK_FALSE(few.hold);
}

TEST_CASE("the shift of an epoch is found to what its readings tell, and taken out", "[measure]") {
  // The half that was set up anew lies opposite the first: the smooth error goes through both.
  const Mechanism mechanism = paper_mechanism();
  const Pose frame{0.30, -0.20, rad_from_deg(0.05)};
  double square = 0;
  int n = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto sound = campaign(seed, 41, {}), moved = campaign(seed, 41, frame);
    const auto back = without_shifts(moved, epoch_shifts(mechanism, moved));
    for (std::size_t k = 40; k < back.size(); ++k) {
      // joint zeros and frame share the shift: judged by the pose, less what the zeros moved it
      const Pose then = forward(mechanism.geometry, sound[k].conditions.cmd_mm).pose;
      const Pose now = forward(mechanism.geometry, back[k].conditions.cmd_mm).pose;
      square +=
          std::pow(back[k].measured->x_mm - sound[k].measured->x_mm - now.x_mm + then.x_mm, 2) +
          std::pow(back[k].measured->y_mm - sound[k].measured->y_mm - now.y_mm + then.y_mm, 2);
      n += 2;
    }
  }
  INFO("rms of what is left of a shift of 0.36 mm: " << std::sqrt(square / n));
  CHECK(std::sqrt(square / n) < 0.06);
}

TEST_CASE("in a frame and out of it is the same pose, and one epoch has no shift", "[measure]") {
  const Pose frame{0.3, -0.2, 0.01}, pose{50, -20, 0.1};
  const Pose back = out_of_frame(frame, in_frame(frame, pose));
  CHECK_THAT(back.x_mm, WithinAbs(pose.x_mm, 1e-12));
  CHECK_THAT(back.y_mm, WithinAbs(pose.y_mm, 1e-12));
  CHECK_THAT(back.phi_rad, WithinAbs(pose.phi_rad, 1e-15));
  CHECK(epoch_shifts(paper_mechanism(), campaign(1, 200, {})).empty());
}
