#include "core/simulate/virtual_robot.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

namespace trammel::simulate {

namespace {

Truth faulty(std::uint64_t seed) {
  Random random(seed);
  Truth truth;
  truth.nominal = machine_of(paper_mechanism());
  truth.actual =
      machine_of({.geometry = tests::random_geometry(random), .home = {}, .limits = {}}).chains;
  truth.drive.lead_scale = {0.003, 0.002, 0.004};
  truth.drive.backlash_mm = {0.08, 0.08, 0.08};
  truth.drive.screw_cos_mm = {0.006, 0.005, 0.004};
  truth.drive.thermal_growth_per_k = {1.2e-5, 1.2e-5, 1.2e-5};
  truth.drive.load_mm = {0.1, 0.2};
  truth.temperature = {18, 3, 2400};
  truth.tracker.sigma_xy_mm = 0.01;
  truth.tracker.sigma_phi_rad = 1e-3;
  truth.seed = seed;
  return truth;
}

Conditions at_home() {
  const Displacements l = inverse(paper_mechanism().geometry, Pose{}).l_mm;
  return {.cmd_mm = l, .from_mm = l, .epoch = 1, .time_s = 0.0, .temp_degc = {}};
}

}  // namespace

TEST_CASE("a robot zeroed at home stands there in position, its attitude stays off", "[simulate]") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Truth truth = faulty(seed);
    truth.zeroed = true;
    truth.phi_zero_rad = rad_from_deg(0.08);
    const Pose pose = VirtualRobot(truth).true_pose(at_home()).pose;
    CHECK_THAT(pose.x_mm, WithinAbs(0, 1e-9));
    CHECK_THAT(pose.y_mm, WithinAbs(0, 1e-9));
    CHECK_THAT(deg_from_rad(pose.phi_rad), WithinAbs(0.08, 1e-9));
    truth.zeroed = false;
    CHECK(VirtualRobot(truth).true_pose(at_home()).pose.vector().norm() > 1e-3);
  }
}

TEST_CASE("zeroing holds at another home pose", "[simulate]") {
  Truth truth = faulty(9);
  truth.nominal.home = {20, -10, 0.03};
  truth.zeroed = true;
  truth.phi_zero_rad = 0.03;
  Conditions c = at_home();
  c.cmd_mm = c.from_mm = inverse(paper_mechanism().geometry, truth.nominal.home).l_mm;
  const Pose pose = VirtualRobot(truth).true_pose(c).pose;
  CHECK((pose.vector() - truth.nominal.home.vector()).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("a reading depends on its number, not on what was read before", "[simulate]") {
  const VirtualRobot robot(faulty(3));
  const Conditions c = at_home();
  const Pose fifth = robot.read(c, 5).pose;
  for (std::uint64_t n = 0; n < 20; ++n) {
    const Pose pose = robot.read(c, n).pose;
    CHECK((pose == fifth) == (n == 5));
  }
  CHECK(VirtualRobot(faulty(3)).read(c, 5).pose == fifth);
  CHECK_FALSE(VirtualRobot(faulty(4)).read(c, 5).pose == fifth);
}

TEST_CASE("noise has the stated sigma and, where asked, correlation from one to the next",
          "[simulate]") {
  constexpr int kReadings = 20000;
  for (const double rho : {0.0, 0.6}) {
    TrackerTruth tracker;
    tracker.sigma_xy_mm = 0.01;
    tracker.sigma_phi_rad = 1e-3;
    tracker.correlation = rho;
    double xx = 0, yy = 0, pp = 0, lag = 0, before = 0;
    for (std::uint64_t n = 1000; n < 1000 + kReadings; ++n) {
      const Pose e = reading_noise(tracker, 7, n);
      xx += e.x_mm * e.x_mm;
      yy += e.y_mm * e.y_mm;
      pp += e.phi_rad * e.phi_rad;
      lag += e.x_mm * before;
      before = e.x_mm;
    }
    // The standard deviation of these estimates is below 1.2 %; 5 % fails once in 10^4 seeds.
    CHECK_THAT(std::sqrt(xx / kReadings), WithinRel(0.01, 0.05));
    CHECK_THAT(std::sqrt(yy / kReadings), WithinRel(0.01, 0.05));
    CHECK_THAT(std::sqrt(pp / kReadings), WithinRel(1e-3, 0.05));
    CHECK_THAT(lag / xx, WithinAbs(rho, 0.04));
  }
}

TEST_CASE("outliers are those that are named and the share that is asked for", "[simulate]") {
  TrackerTruth tracker;
  tracker.outlier_mm = 2;
  tracker.outliers = {17};
  for (std::uint64_t n = 0; n < 40; ++n) {
    const Pose e = reading_noise(tracker, 1, n);
    CHECK_THAT(std::hypot(e.x_mm, e.y_mm), WithinAbs(n == 17 ? 2.0 : 0.0, 1e-12));
  }
  tracker.outlier_share = 0.1;
  int wrong = 0;
  for (std::uint64_t n = 100; n < 2100; ++n) {
    const Pose e = reading_noise(tracker, 1, n);
    wrong += std::hypot(e.x_mm, e.y_mm) > 1 ? 1 : 0;
  }
  CHECK(wrong > 140);  // expected 200, standard deviation 13
  CHECK(wrong < 260);
}

TEST_CASE("the machine warms up along its exponential", "[simulate]") {
  Truth truth = faulty(1);
  truth.temperature = {20, 3, 2400};
  const VirtualRobot robot(truth);
  CHECK(robot.temperature_degc(0) == 20);
  CHECK(robot.temperature_degc(-100) == 20);
  CHECK_THAT(robot.temperature_degc(2400), WithinAbs(20 + 3 * 0.6321205588285577, 1e-12));
  CHECK_THAT(robot.temperature_degc(1e9), WithinAbs(23, 1e-12));
}

TEST_CASE("a truth that makes no robot is refused by the name of the field", "[simulate]") {
  const auto refused = [](auto change, const char* field) {
    Truth truth = faulty(1);
    change(truth);
    CHECK_THROWS_WITH(VirtualRobot(truth), Contains(field));
    CHECK_THROWS_AS(VirtualRobot(truth), InputError);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([&](Truth& t) { t.drive.lead_scale[1] = nan; }, "drive.lead_scale");
  refused([&](Truth& t) { t.tracker.sigma_xy_mm = -1; }, "tracker.sigma_xy_mm");
  refused([&](Truth& t) { t.tracker.correlation = 1; }, "tracker.correlation");
  refused([&](Truth& t) { t.tracker.outlier_share = 1.5; }, "tracker.outlier_share");
  refused([&](Truth& t) { t.temperature.tau_s = 0; }, "temperature.tau_s");
  refused([&](Truth& t) { t.motion.speed_mm_s = 0; }, "motion.speed_mm_s");
  refused([&](Truth& t) { t.bumps = {{3, 0, 1, 0}}; }, "bumps.rail");
  refused([&](Truth& t) { t.harmonics = {{0, 0, 0, 0}}; }, "harmonics.period_mm");
  refused([&](Truth& t) { t.actual[1][3] = 0; }, "S_mm");
  refused([&](Truth& t) { t.nominal.home = {2000, 0, 0}; }, "home");
}

}  // namespace trammel::simulate
