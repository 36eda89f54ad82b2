// The instrument alone: what it sees, how long it takes, and when it cannot.

#include "app/emulate/tracker.hpp"

#include <array>
#include <cmath>

#include "app/files/numbers.hpp"
#include "core/error.hpp"
#include "core/measure/base_frame.hpp"
#include "core/mechanism/inverse.hpp"
#include "tests/app/emulate/emulated.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::emulate {

namespace {

/// A tracker that sees rails where the test puts them.
struct Instrument {
  Faults faults;
  simulate::VirtualRobot robot;
  Standing standing;
  EmulatedTracker tracker;

  explicit Instrument(const simulate::Truth& truth = tests::emulated_truth(),
                      TrackerSetup setup = default_tracker(), double speedup = 1)
      : robot(truth),
        tracker(
            robot, std::move(setup), [this] { return standing; }, faults, speedup) {
    standing.l_mm = standing.from_mm =
        inverse(paper_mechanism().geometry, Pose{20, -30, 0.05}).l_mm;
  }

  std::string ask(const std::string& line) {
    const Answer answer = tracker.line(line);
    return answer.finish ? answer.finish() : answer.bytes;
  }
};

Eigen::Vector3d point_of(const std::string& reply) {
  Eigen::Vector3d p;
  const std::size_t at = reply.find("result ");
  REQUIRE(at != std::string::npos);
  REQUIRE(std::sscanf(reply.c_str() + at, "result %lf,%lf,%lf", &p[0], &p[1], &p[2]) == 3);
  return p;
}

simulate::Truth noiseless() {
  simulate::Truth truth = tests::emulated_truth();
  truth.tracker.sigma_xy_mm = truth.tracker.sigma_phi_rad = 0;
  return truth;
}

}  // namespace

TEST_CASE("points are where the platform carries them, in the tracker's own frame", "[emulate]") {
  Instrument instrument(noiseless());
  const TrackerSetup setup = default_tracker();
  const Conditions conditions{.cmd_mm = instrument.standing.l_mm,
                              .from_mm = instrument.standing.from_mm,
                              .epoch = 1,
                              .time_s = 10.0,
                              .temp_degc = {}};
  const Pose pose = instrument.robot.seen_pose(conditions).pose;
  for (const Nest& nest : setup.nests) {
    Eigen::Vector3d at = nest.at_mm;
    if (nest.on_platform) {
      at.head<2>() = Eigen::Rotation2Dd(pose.phi_rad) * nest.at_mm.head<2>() +
                     Eigen::Vector2d(pose.x_mm, pose.y_mm);
    }
    const Eigen::Vector3d p =
        point_of(instrument.ask("!MEAS_SINGLE_POINT:A;" + nest.group + ";" + nest.point));
    CAPTURE(nest.group, nest.point);
    CHECK((p - setup.from_base * at).norm() < 1e-3);  // it warms up from point to point
  }
}

TEST_CASE("registered by its base nests, the tracker's points give back the pose", "[emulate]") {
  simulate::Truth truth = tests::emulated_truth();
  truth.tracker.sigma_xy_mm = 0.005;
  Instrument instrument(truth);
  std::vector<NestPoint> base, base_seen, seen;
  NestFrame platform;
  for (const Nest& nest : default_tracker().nests) {
    const Eigen::Vector3d p =
        point_of(instrument.ask("!MEAS_SINGLE_POINT:A;" + nest.group + ";" + nest.point));
    if (nest.group == "BASE") {
      base.push_back({nest.point, nest.at_mm});
      base_seen.push_back({nest.point, p});
    } else if (nest.group == "PLATFORM") {
      platform.body.push_back({nest.point, nest.at_mm});
      seen.push_back({nest.point, p});
    }
  }
  platform.T_B_T = frame_of_base(base_seen, base).T_B_T;
  const NestPose pose = pose_of_nests(seen, platform, truth.tracker.sigma_xy_mm);
  REQUIRE(pose.ok());
  const Conditions conditions{.cmd_mm = instrument.standing.l_mm,
                              .from_mm = instrument.standing.from_mm,
                              .epoch = 1,
                              .time_s = 40.0,
                              .temp_degc = {}};
  const Pose truly = instrument.robot.seen_pose(conditions).pose;
  // 5 standard deviations: 5 um a coordinate, four base nests 500 mm and three nests 87 mm out.
  CHECK_THAT(pose.pose.x_mm, WithinAbs(truly.x_mm, 0.02));
  CHECK_THAT(pose.pose.y_mm, WithinAbs(truly.y_mm, 0.02));
  CHECK_THAT(pose.pose.phi_rad, WithinAbs(truly.phi_rad, 2e-4));
}

TEST_CASE("an offset is the pose that the virtual robot's own tracker reads", "[emulate]") {
  Instrument instrument;
  CHECK(instrument.ask("?OFFSET:PLATFORM;BASE").starts_with("ERR-340 "));  // not measured yet
  CHECK(instrument.ask("!CMDEXE:PLATFORM") == "ACK-106 Successfully ran CMD PLATFORM\r\n");
  const std::string reply = instrument.ask("?OFFSET:PLATFORM;BASE");
  CHECK(reply == instrument.ask("?OFFSET:PLATFORM;BASE"));  // it tells, and does not measure
  const Conditions conditions{.cmd_mm = instrument.standing.l_mm,
                              .from_mm = instrument.standing.from_mm,
                              .epoch = 1,
                              .time_s = 10.0,
                              .temp_degc = {}};
  const Pose pose = instrument.robot.read(conditions, 1).pose;
  double x = 0, y = 0, rz = 0;
  REQUIRE(std::sscanf(reply.c_str(),
                      "ACK-300 Object Offset Report FramePLATFORM_1;X:%lf;Y:%lf;Z:%*f;Rx:%*f;"
                      "Ry:%*f;Rz:%lf;",
                      &x, &y, &rz) == 3);
  CHECK_THAT(x, WithinAbs(pose.x_mm, 1e-6));
  CHECK_THAT(y, WithinAbs(pose.y_mm, 1e-6));
  CHECK_THAT(rz, WithinAbs(deg_from_rad(pose.phi_rad), 1e-6));
}

TEST_CASE("noise has the stated size, and the same sequence gets the same bytes", "[emulate]") {
  simulate::Truth truth = tests::emulated_truth();
  truth.temperature.rise_k = 0;
  Instrument first(truth), second(truth);
  constexpr int kReadings = 400;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = sum;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (int k = 0; k < kReadings; ++k) {
    const std::string reply = first.ask("!MEAS_SINGLE_POINT:A;BASE;B2");
    CHECK(reply == second.ask("!MEAS_SINGLE_POINT:A;BASE;B2"));
    if (k == 0) origin = point_of(reply);
    const Eigen::Vector3d p = point_of(reply) - origin;
    sum += p;
    squares += p.cwiseAbs2();
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double mean = sum[axis] / kReadings;
    const double sigma = std::sqrt(squares[axis] / kReadings - mean * mean);
    CHECK_THAT(sigma, WithinAbs(0.01, 0.0015));  // 4 standard deviations of such an estimate
  }
}

TEST_CASE("a measurement takes its time, and the instrument is busy meanwhile", "[emulate]") {
  Instrument instrument(tests::emulated_truth(), default_tracker(), 50);
  Answer answer = instrument.tracker.line("!MEAS_SINGLE_POINT:A;BASE;B1");
  CHECK_THAT(answer.after.count(), WithinAbs(10.0 / 50, 1e-12));
  CHECK_THAT(instrument.ask("?STAT"), Contains("BUSY"));
  CHECK(instrument.ask("!MEAS_SINGLE_POINT:A;BASE;B1").starts_with("ERR-201 "));
  CHECK_THAT(answer.finish(), Contains("ACK-300"));
  CHECK_THAT(instrument.ask("?STAT"), Contains("READY"));
}

TEST_CASE("who leaves in the middle of a measurement leaves no busy instrument", "[emulate]") {
  Instrument instrument;
  { const Answer dropped = instrument.tracker.line("!MEAS_SINGLE_POINT:A;BASE;B1"); }
  CHECK_THAT(instrument.ask("?STAT"), Contains("READY"));
}

TEST_CASE("a measurement fails when it is halted or what it measures moves", "[emulate]") {
  Instrument instrument;
  Answer answer = instrument.tracker.line("!MEAS_SINGLE_POINT:A;BASE;B1");
  CHECK(instrument.ask("!HALT") == "ACK-300 OK\r\n");
  CHECK_THAT(answer.finish(), Contains("ERR-305") && Contains("halted"));

  answer = instrument.tracker.line("!MEAS_SINGLE_POINT:A;PAIR;P1");
  instrument.standing.l_mm[0] += 1;
  CHECK_THAT(answer.finish(), Contains("ERR-305") && Contains("moves"));

  instrument.standing.moving = true;
  CHECK_THAT(instrument.ask("!MEAS_SINGLE_POINT:A;PAIR;P1"), Contains("ERR-305"));
  instrument.standing.moving = false;
  CHECK_THAT(instrument.ask("!MEAS_SINGLE_POINT:A;PAIR;P1"), Contains("ACK-300"));
}

TEST_CASE("a laser that was off warms up before it measures", "[emulate]") {
  TrackerSetup setup = default_tracker();
  setup.warm_up_s = 1e-3;
  Instrument instrument(tests::emulated_truth(), setup, 1e-3);  // a second of the wall
  CHECK(instrument.ask("?LSTA") == "ACK-300 LON\r\n");
  instrument.ask("!LST:0");
  instrument.ask("!LST:1");
  CHECK_THAT(instrument.ask("?LSTA"), Contains("ACK-300 WARM, 0.00 seconds"));
  CHECK(instrument.ask("!MEAS_SINGLE_POINT:A;BASE;B1").starts_with("ERR-338"));
}

TEST_CASE("a stage that does not answer makes the instrument not ready", "[emulate]") {
  Faults faults;
  EmulatedTracker tracker(
      simulate::VirtualRobot(tests::emulated_truth()), default_tracker(),
      []() -> Standing { throw DeviceError({.what = "no stage"}); }, faults, 1);
  CHECK_THAT(tracker.line("!MEAS_SINGLE_POINT:A;BASE;B1").bytes,
             Contains("ERR-338") && Contains("no stage"));
}

TEST_CASE("nests and stand are read from a file, and mistakes named", "[emulate]") {
  const tests::TemporaryFolder folder;
  const auto read = [&folder](const std::string& text) {
    return read_tracker_setup(folder.write("nests.json", text));
  };
  const TrackerSetup setup = read(R"({"format": "emulated-tracker/1", "warm_up_s": 3,
    "from_base": {"x_mm": 1, "y_mm": 2, "z_mm": 3, "rz_deg": 90},
    "nests": [{"group": "G", "point": "P", "on": "platform", "x_mm": 10, "y_mm": 20, "z_mm": 5}]})");
  REQUIRE(setup.nests.size() == 1);
  CHECK(setup.nests[0].on_platform);
  CHECK((setup.from_base * setup.nests[0].at_mm - Eigen::Vector3d(-19, 12, 8)).norm() < 1e-12);
  CHECK_THROWS_WITH(read(R"({"format": "emulated-tracker/1", "nests":
    [{"group": "G", "point": "P", "on": "moon", "x_mm": 1, "y_mm": 2}]})"),
                    Contains("moon") && Contains("platform"));
}

}  // namespace trammel::emulate
