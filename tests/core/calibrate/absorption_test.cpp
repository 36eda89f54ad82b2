#include "core/calibrate/absorption.hpp"

#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

/// 240 readings in random order over the plane and orientation, on a robot with machining errors.
std::vector<Reading> campaign(Random& random, int n = 240) {
  return measure(random_geometry(random), random_poses(n, random), random);
}

AbsorptionTest tested(const std::vector<Reading>& readings) {
  return absorption_test(fit_geometry(nominal_model(paper_mechanism()), readings, kSigma),
                         readings);
}

int alarms(const HalvesTest& test) { return test.shifts.empty() ? 0 : 1; }

void count_false_alarms(int trials, int most) {
  Random random(201);
  int in_time = 0, control = 0;
  for (int k = 0; k < trials; ++k) {
    const AbsorptionTest test = tested(campaign(random));
    REQUIRE(test.in_time.tests > 18);
    in_time += alarms(test.in_time);
    control += alarms(test.interleaved);
  }
  INFO(in_time << " and " << control << " of " << trials);
  CHECK(in_time <= most);
  CHECK(control <= most);
}

}  // namespace

TEST_CASE("the absorption alarm is false in no more than 1 of 100 clean campaigns", "[calibrate]") {
  // binomial(200, 0.01): more than 7 in 0.1 % of runs
  count_false_alarms(200, 7);
}

TEST_CASE("the absorption alarm's false-alarm rate, counted", "[.][slow]") {
  // binomial(4000, 0.01): mean 40, sd 6.3; more than 60 in 0.1 % of runs
  count_false_alarms(4000, 60);
}

TEST_CASE("a rail that grows while it is measured raises the alarm in time, not in the control",
          "[calibrate]") {
  Random random(202);
  int found = 0, control = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Geometry truth = random_geometry(random);
    const auto poses = random_poses(240, random);
    auto readings = measure(truth, poses, random);
    for (std::size_t k = 0; k < readings.size(); ++k) {  // rail 2: 40 um over the campaign
      Displacements l = readings[k].conditions.cmd_mm;
      const Pose before = forward(truth, l).pose;
      l[1] += 0.04 * static_cast<double>(k) / 240;
      const Pose after = forward(truth, l).pose;
      readings[k].measured =
          Pose::from(readings[k].measured->vector() + after.vector() - before.vector());
    }
    const AbsorptionTest test = tested(readings);
    found += alarms(test.in_time);
    control += alarms(test.interleaved);
  }
  CHECK(found >= 18);
  CHECK(control <= 2);
}

TEST_CASE("a rail that turns half-way is named, with its size", "[calibrate]") {
  Random random(203);
  const Geometry truth = paper_mechanism().geometry;
  Geometry later = truth;
  later.chains[0].alpha_rad += 5e-4;
  const auto poses = random_poses(240, random);
  auto readings = measure(truth, poses, random);
  const auto second = measure(later, poses, random);
  for (std::size_t k = 120; k < 240; ++k) readings[k].measured = second[k].measured;
  const AbsorptionTest test = tested(readings);
  REQUIRE_FALSE(test.in_time.shifts.empty());
  for (const HalfShift& s : test.in_time.shifts) {
    INFO(s.name << " " << s.shift << " +- " << s.standard_uncertainty);
    CHECK(std::abs(s.sigmas()) > test.in_time.limit_sigmas);
    if (s.name == "alpha_1") CHECK_THAT(s.shift, WithinAbs(5e-4, 4 * s.standard_uncertainty));
  }
  const bool named = std::ranges::any_of(test.in_time.shifts,
                                         [](const HalfShift& s) { return s.name == "alpha_1"; });
  CHECK(named);
  CHECK(test.interleaved.shifts.empty());
}

TEST_CASE("a second set-up in the second half alone raises no alarm", "[calibrate]") {
  Random random(204);
  int false_alarms = 0;
  for (int trial = 0; trial < 20; ++trial) {
    auto readings = campaign(random);
    for (std::size_t k = 120; k < readings.size(); ++k) {
      readings[k].conditions.epoch = 2;
      readings[k].measured->x_mm += 0.3;  // the frame was set up anew
    }
    false_alarms += alarms(tested(readings).in_time);
  }
  CHECK(false_alarms <= 2);  // binomial(20, 0.01): more than 2 in 0.1 %
}

TEST_CASE("too few readings to halve are said to be too few", "[calibrate]") {
  Random random(205);
  const AbsorptionTest test = tested(campaign(random, 8));
  CHECK(test.in_time.tests == 0);
  CHECK_THAT(test.in_time.untested, Contains("too few readings"));
}
