// examples/paper/robot.json: is it the robot it says it is?

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "app/device/open.hpp"
#include "app/device/simulated.hpp"
#include "app/files/robot_json.hpp"
#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/plan/named.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"

namespace trammel::device {

namespace {

const std::string kRobot = tests::source_folder() + "/examples/paper/robot.json";

struct Figures {
  double mean_mm = 0, max_mm = 0, min_mm = std::numeric_limits<double>::infinity();
  double attitude_deg = 0;
  double inner_mm = 0, outer_mm = 0;  // mean within 50 mm of the centre, and beyond 80 mm
};

/// What a baseline session reads: every point as it comes, nominal commands.
Figures baseline(const simulate::VirtualRobot& robot, const Plan& plan) {
  const Mechanism nominal = mechanism_of(robot.truth().nominal);
  const std::vector<double> times_s = schedule_s(robot, plan, 0);
  Displacements at = inverse(nominal.geometry, nominal.home).l_mm, from = at;
  Figures f;
  int n_inner = 0, n_outer = 0;
  for (std::size_t k = 0; k < plan.points.size(); ++k) {
    const Pose& target = plan.points[k].target;
    const Displacements cmd = inverse(nominal.geometry, target).l_mm;
    from = planned_move(plan, plan.points[k], cmd, at, from).from_mm;
    at = cmd;
    Conditions conditions;
    conditions.cmd_mm = cmd;
    conditions.from_mm = from;
    conditions.time_s = times_s[k];
    const Pose pose = robot.read(conditions, k + 1).pose;
    const double off = std::hypot(pose.x_mm - target.x_mm, pose.y_mm - target.y_mm);
    const double radius = std::hypot(target.x_mm, target.y_mm);
    f.mean_mm += off / static_cast<double>(plan.points.size());
    f.max_mm = std::max(f.max_mm, off);
    f.min_mm = std::min(f.min_mm, off);
    f.attitude_deg +=
        std::abs(deg_from_rad(pose.phi_rad)) / static_cast<double>(plan.points.size());
    if (radius < 50) f.inner_mm += off, ++n_inner;
    if (radius > 80) f.outer_mm += off, ++n_outer;
  }
  f.inner_mm /= n_inner;
  f.outer_mm /= n_outer;
  return f;
}

}  // namespace

TEST_CASE("the 80 points start at 0.21 mm +- 10 % and 0.07 to 0.09 deg whatever the noise",
          "[device]") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    simulate::Truth truth = read_robot(kRobot);
    truth.seed += seed;
    const Figures f = baseline(simulate::VirtualRobot(truth), named_plan("paper-80"));
    INFO("seed " << truth.seed << ": mean " << f.mean_mm << " mm, attitude " << f.attitude_deg);
    CHECK_THAT(f.mean_mm, WithinRel(0.21, 0.10));
    CHECK(f.attitude_deg > 0.07);
    CHECK(f.attitude_deg < 0.09);
    CHECK(f.outer_mm > 2 * f.inner_mm);  // errors grow outwards
  }
}

TEST_CASE("the paper's robot carries what its file says, on physical grounds", "[device]") {
  const simulate::Truth truth = read_robot(kRobot);
  const Eigen::Vector3d& k = truth.drive.lead_scale;
  CHECK_THAT(k[0] / k[1], WithinAbs(32.0 / 20, 1e-9));
  CHECK_THAT(k[2] / k[1], WithinAbs(41.0 / 20, 1e-9));
  CHECK_THAT(k.mean(), WithinAbs(0.004, 0.001));
  CHECK_THAT(truth.drive.backlash_mm.mean(), WithinAbs(0.08, 0.005));
  for (int i = 0; i < kChains; ++i) {
    const double periodic = std::hypot(truth.drive.screw_sin_mm[i], truth.drive.screw_cos_mm[i]);
    CHECK_THAT(periodic, WithinAbs(0.006, 2e-4));
  }
  CHECK(truth.temperature.rise_k == 3);
  CHECK(truth.tracker.sigma_xy_mm == 0.010);
  CHECK_THAT(deg_from_rad(truth.tracker.sigma_phi_rad), WithinAbs(0.055, 1e-12));
  CHECK(truth.zeroed);
  CHECK_THAT(std::abs(deg_from_rad(truth.phi_zero_rad)), WithinAbs(0.08, 1e-12));
  Machine built = truth.nominal;
  built.chains = truth.actual;
  const GeometryVector error =
      to_vector(geometry_of(built)) - to_vector(geometry_of(truth.nominal));
  for (int j = 0; j < kGeometryParameters; ++j) {
    const GeometryParameter& p = geometry_parameters()[static_cast<std::size_t>(j)];
    CHECK(std::abs(error[j]) <= p.tolerance);  // one standard deviation of machining
  }
}

TEST_CASE("a robot's file that is wrong is refused by file, line and field", "[device]") {
  const std::string mechanism = R"({"type": "3-PRR", "chains": [
    {"alpha_deg": 270, "beta_deg": 30, "r_mm": 100, "S_mm": 430, "R_mm": 733},
    {"alpha_deg": 30, "beta_deg": 150, "r_mm": 100, "S_mm": 430, "R_mm": 733},
    {"alpha_deg": 150, "beta_deg": 270, "r_mm": 100, "S_mm": 430, "R_mm": 733}]})";
  const auto text = [&](const std::string& rest) {
    return "{\"format\": \"robot/1\", \"mechanism\": " + mechanism + rest + "}";
  };
  CHECK_NOTHROW(parse_robot(text(""), "r.json"));
  CHECK_THROWS_WITH(parse_robot(text(R"(, "drive": {"lead_scale": [1, 2]})"), "r.json"),
                    Contains("r.json:4") && Contains("drive.lead_scale"));
  CHECK_THROWS_WITH(parse_robot(text(R"(, "drive": {"leadscale": [1, 2, 3]})"), "r.json"),
                    Contains("leadscale"));
  CHECK_THROWS_WITH(parse_robot(text(R"(, "tracker": {"sigma_xy_mm": -1})"), "r.json"),
                    Contains("r.json:4") && Contains("tracker.sigma_xy_mm"));
  CHECK_THROWS_WITH(parse_robot(text(R"(, "bumps": [{"rail": 4, "centre_mm": 1, "width_mm": 1,
                    "height_mm": 1}])"),
                                "r.json"),
                    Contains("bumps[0].rail"));
  CHECK_THROWS_WITH(parse_robot(text(R"(, "seed": "one")"), "r.json"), Contains("seed"));
}

TEST_CASE("a stage of no known kind is refused with those there are", "[device]") {
  CHECK_THROWS_WITH(open_devices("galil2:host", "sim"), Contains("sim:FILE"));
  CHECK_THROWS_AS(open_devices("sim", "sim"), UsageError);
  CHECK_THROWS_AS(open_devices(std::string("sim:") + kRobot, "leica"), UsageError);
  CHECK_THROWS_AS(open_devices("sim:no-such-file.json", "sim"), NotFoundError);
}

TEST_CASE("the simulated stage refuses to move before homing and beyond its stroke", "[device]") {
  const Devices devices = open_devices(std::string("sim:") + kRobot, "sim");
  const Watch watch = [] { return Status::ok; };
  CHECK_FALSE(devices.stage->homed());
  CHECK(devices.stage->move({260, 260, 260}, watch).status == Status::fault);
  CHECK(devices.stage->home().ok());
  CHECK(devices.stage->move({260, 260, 260}, watch).ok());
  CHECK(devices.stage->move({260, 601, 260}, watch).status == Status::limit);
  CHECK(devices.stage->move({260, std::nan(""), 260}, watch).status == Status::limit);
  CHECK(devices.stage->stop().encoder_mm == Displacements(260, 260, 260));
}

TEST_CASE("a watch that is not ok stops the simulated stage at that sample", "[device]") {
  const Devices devices = open_devices(std::string("sim:") + kRobot, "sim");
  REQUIRE(devices.stage->home().ok());
  const Displacements begin = devices.stage->stop().encoder_mm, end(270, 270, 270);
  for (int sample = 1;; ++sample) {
    int asked = 0;
    const StageReport report = devices.stage->move(
        end, [&] { return ++asked == sample ? Status::beam_broken : Status::ok; });
    CHECK(report.encoder_mm == devices.stage->stop().encoder_mm);
    if (report.ok()) {
      CHECK(sample == asked + 1);
      CHECK(asked >= 4);
      break;
    }
    CHECK(report.status == Status::beam_broken);
    CHECK(asked == sample);  // nothing is asked, and nothing moves, after the one that was not ok
    REQUIRE(devices.stage->home().ok());
  }
  CHECK(devices.stage->stop().encoder_mm == end);
  CHECK_FALSE(begin == end);
}

}  // namespace trammel::device
