#include "app/device/t2sa.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/scripted_server.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

const Occasion kOccasion{};
const std::vector<NestPoint> kBody = {
    {"P1", {0, 86.6, 12}}, {"P2", {-75, -43.3, 12}}, {"P3", {75, -43.3, 12}}};
const Eigen::Isometry3d kTrackerInBase =
    fixed_axes({500, -2000, 300}, {rad_from_deg(0.4), rad_from_deg(-0.3), rad_from_deg(25)});

std::string point_line(const std::string& name, const Eigen::Vector3d& at_mm,
                       const char* good = "True", const char* stamp = "11/27/2026 14:00:00") {
  return fmt::format("ACK-300 Single Point Measurement {} result {:.6f},{:.6f},{:.6f} {} {}\r\n",
                     name, at_mm.x(), at_mm.y(), at_mm.z(), stamp, good);
}

Eigen::Vector3d seen(const Eigen::Vector3d& in_base_mm) {
  return kTrackerInBase.inverse() * in_base_mm;
}

Eigen::Vector3d in_base(const Eigen::Vector3d& on_body_mm, const Pose& pose) {
  return fixed_axes({pose.x_mm, pose.y_mm, 0}, {0, 0, pose.phi_rad}) * on_body_mm;
}

/// A T2SA that is on, with the nests of a platform at `pose`.
struct Sa {
  tests::ScriptedServer server{"\r\n"};
  T2saSettings settings;

  Sa() {
    server.on("?LSTA", "ACK-300 LON\r\n");
    server.on("?STAT", "ACK-300 Instrument is connected\r\n");
    settings.server = {"127.0.0.1", server.port()};
    settings.connect_timeout_s = 10;
    settings.reply_timeout_s = 0.2;
    settings.nests.frame.body = kBody;
    settings.nests.frame.T_B_T = kTrackerInBase;
    settings.nests.sigma_mm = 0.005;
    settings.by_host_clock = false;  // what it says is the same for ever
    for (const NestPoint& nest : kBody) {
      settings.points.push_back({nest.nest, "A;platform;" + nest.nest});
    }
    stand({12.5, -7.25, 0.01});
  }

  [[nodiscard]] static std::string ask(const std::string& nest) {
    return "!MEAS_SINGLE_POINT:A;platform;" + nest;
  }
  void stand(const Pose& pose) {
    for (const NestPoint& nest : kBody) {
      server.on(ask(nest.nest), point_line(nest.nest, seen(in_base(nest.at_mm, pose))));
    }
  }
};

}  // namespace

TEST_CASE("replies of T2SA are read as they stand, and others are not", "[device][t2sa]") {
  const auto reply = parse_t2sa_reply("ERR-201 Command rejected. SA is busy.");
  REQUIRE(reply);
  CHECK_FALSE(reply->accepted);
  CHECK(reply->code == 201);
  CHECK(reply->body == "Command rejected. SA is busy.");
  CHECK(parse_t2sa_reply("ACK-300")->body.empty());
  for (const char* line : {"", "ACK", "ACK-30", "ACK-3x0 hello", "NAK-300 hello", "ACK-300hello"}) {
    CAPTURE(line);
    CHECK_FALSE(parse_t2sa_reply(line));
  }
  const auto point = parse_t2sa_point(
      "Single Point Measurement PT result 1.500000,-2.250000,3.000000 02/12/2025 16:40:57 True");
  REQUIRE(point);
  CHECK(point->at_mm == Eigen::Vector3d(1.5, -2.25, 3));
  CHECK(point->good);
  for (const char* body : {"Single Point Measurement PT result 1,2 02/12/2025 16:40:57 True",
                           "Single Point Measurement PT result 1,2,nan 02/12/2025 16:40:57 True",
                           "Single Point Measurement PT result 1,2,3 02/12/2025 16:40:57 Perhaps",
                           "Single Point Measurement PT result 1,2,3", "READY"}) {
    CAPTURE(body);
    CHECK_FALSE(parse_t2sa_point(body));
  }
  const auto frame = parse_t2sa_offset(
      "Object Offset Report FrameM2_1;X:1.0;Y:2.0;Z:3.0;Rx:0;Ry:0;Rz:90.0;02/12/2025 16:40:57");
  REQUIRE(frame);
  CHECK((frame->T * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm() < 1e-12);
  CHECK(frame->name == "FrameM2_1");
  CHECK(frame->stamp_s == parse_stamp_s("02/12/2025 16:40:57"));
  CHECK(point->name == "PT");
  CHECK(point->stamp_s == frame->stamp_s);
  CHECK_FALSE(parse_t2sa_offset("Object Offset Report F;X:1;Y:2;Z:3;Rx:0;Ry:0;Rz:no;now"));
}

TEST_CASE("three nests give the pose, and what came is kept", "[device][t2sa]") {
  Sa sa;
  T2saTracker tracker(sa.settings);
  CHECK(tracker.beam() == Status::ok);
  const PoseReport report = tracker.measure(kOccasion);
  INFO(report.detail);
  REQUIRE(report.ok());
  CHECK(report.pose.x_mm == Approx(12.5).margin(2e-6));
  CHECK(report.pose.y_mm == Approx(-7.25).margin(2e-6));
  CHECK(report.pose.phi_rad == Approx(0.01).margin(2e-8));
  CHECK(std::count(report.raw_reply.begin(), report.raw_reply.end(), '\n') == 2);
  CHECK(report.raw_reply.find("11/27/2026 14:00:00") != std::string::npos);
}

TEST_CASE("two nests give a pose too", "[device][t2sa]") {
  Sa sa;
  sa.settings.nests.frame.body.pop_back();
  sa.settings.points.pop_back();
  const PoseReport report = T2saTracker(sa.settings).measure(kOccasion);
  REQUIRE(report.ok());
  CHECK(report.pose.phi_rad == Approx(0.01).margin(2e-8));
}

TEST_CASE("an object is measured as a whole and its frame is the pose", "[device][t2sa]") {
  Sa sa;
  sa.settings.points.clear();
  sa.settings.object_group = "platform";
  const Eigen::Isometry3d in_tracker =
      kTrackerInBase.inverse() * fixed_axes({3, 4, 0}, {0, 0, rad_from_deg(-2)});
  const Eigen::Matrix3d R = in_tracker.linear();
  const Eigen::Vector3d t = in_tracker.translation();
  sa.server.on("!CMDEXE:platform", "ACK-106 Successfully ran CMD platform\r\n");
  sa.server.on(
      "?POS platform",
      fmt::format(
          "ACK-300 Object Offset Report FramePlatform_1;X:{:.9f};Y:{:.9f};Z:{:.9f};Rx:{:.9f};"
          "Ry:{:.9f};Rz:{:.9f};11/27/2026 14:00:00\r\n",
          t.x(), t.y(), t.z(), deg_from_rad(std::atan2(R(2, 1), R(2, 2))),
          deg_from_rad(std::asin(-R(2, 0))), deg_from_rad(std::atan2(R(1, 0), R(0, 0)))));
  const PoseReport report = T2saTracker(sa.settings).measure(kOccasion);
  INFO(report.detail);
  REQUIRE(report.ok());
  CHECK(report.pose.x_mm == Approx(3).margin(1e-6));
  CHECK(report.pose.y_mm == Approx(4).margin(1e-6));
  CHECK(report.pose.phi_rad == Approx(rad_from_deg(-2)).margin(1e-9));
}

TEST_CASE("the base nests tell where the tracker stands, once an epoch", "[device][t2sa]") {
  Sa sa;
  sa.settings.nests.frame.T_B_T.setIdentity();
  for (const NestPoint& nest :
       {NestPoint{"B1", {700, 0, 0}}, {"B2", {-350, 600, 5}}, {"B3", {-350, -600, -5}}}) {
    sa.settings.base.push_back(nest);
    sa.settings.base_points.push_back({nest.nest, "A;base;" + nest.nest});
    sa.server.on("!MEAS_SINGLE_POINT:A;base;" + nest.nest, point_line(nest.nest, seen(nest.at_mm)));
  }
  T2saTracker tracker(sa.settings);
  for (int k = 0; k < 2; ++k) {
    const PoseReport report = tracker.measure(kOccasion);
    INFO(report.detail);
    REQUIRE(report.ok());
    CHECK(report.pose.x_mm == Approx(12.5).margin(1e-5));
    CHECK(report.pose.phi_rad == Approx(0.01).margin(1e-7));
  }
  CHECK(sa.server.count("!MEAS_SINGLE_POINT:A;base;B2") == 1);
  const BaseReport base = tracker.measure_base(kOccasion);
  REQUIRE(base.ok());
  CHECK(base.drift.n_nests == 3);
  CHECK_FALSE(base.drift.moved);
  CHECK(sa.server.count("!MEAS_SINGLE_POINT:A;base;B2") == 2);
  REQUIRE(tracker.measure({.reading = 0, .time_s = 0, .epoch = 2}).ok());
  CHECK(sa.server.count("!MEAS_SINGLE_POINT:A;base;B2") == 3);
}

TEST_CASE("each refusal of T2SA has its status, and keeps its words", "[device][t2sa]") {
  struct Case {
    const char* answer;
    Status status;
    const char* words;
  };
  for (const Case& c :
       {Case{"ERR-305 Measurement of point failed\r\n", Status::beam_broken, "ERR-305"},
        {"ERR-338 Instrument not ready\r\n", Status::beam_broken, "not ready"},
        {"ERR-304 Drift tolerance exceeded\r\n", Status::unstable, "ERR-304"},
        {"ERR-306 No such target\r\n", Status::fault, "ERR-306"},
        {"ERR-341 Not connected to SA\r\n", Status::fault, "ERR-341"},
        {"ERR-200 Command rejected\r\n", Status::fault, "ERR-200"},
        {"ERR-201 SA is busy\r\n", Status::timeout, "ERR-201"},
        {"ACK-300 Measured well\r\n", Status::timeout, "nobody asked for"},
        {"measured well\r\n", Status::fault, "no known form"}}) {
    CAPTURE(c.answer);
    Sa sa;
    sa.server.on(Sa::ask("P2"), std::string(c.answer));
    const PoseReport report = T2saTracker(sa.settings).measure(kOccasion);
    CHECK(report.status == c.status);
    CHECK_THAT(report.detail, Catch::Matchers::Contains(c.words));
  }
}

TEST_CASE("a point that was not accepted, or points of no rigid body, are unstable",
          "[device][t2sa]") {
  Sa sa;
  const Eigen::Vector3d at = seen(in_base(kBody[0].at_mm, {12.5, -7.25, 0.01}));
  sa.server.on(Sa::ask("P1"), point_line("P1", at, "False"));
  CHECK(T2saTracker(sa.settings).measure(kOccasion).status == Status::unstable);
  sa.server.on(Sa::ask("P1"), point_line("P1", at + Eigen::Vector3d(0.1, 0, 0)));
  const PoseReport report = T2saTracker(sa.settings).measure(kOccasion);
  CHECK(report.status == Status::unstable);
  CHECK_THAT(report.detail, Catch::Matchers::Contains("not rigid"));
  // A platform that tilts: lengths in space stay.
  sa.stand({12.5, -7.25, 0.01});
  sa.settings.nests.out_of_plane_mm = 0.02;
  for (const NestPoint& nest : kBody) {
    const Eigen::Vector3d tilted = fixed_axes({0, 0, 0}, {0.001, 0, 0}) * nest.at_mm;
    sa.server.on(Sa::ask(nest.nest), point_line(nest.nest, seen(tilted)));
  }
  CHECK_THAT(T2saTracker(sa.settings).measure(kOccasion).detail,
             Catch::Matchers::Contains("out of its plane"));
}

TEST_CASE("two nests swapped turn the triangle over, which is a fault", "[device][t2sa]") {
  Sa sa;
  std::swap(sa.settings.points[0].address, sa.settings.points[1].address);
  const PoseReport report = T2saTracker(sa.settings).measure(kOccasion);
  CHECK(report.status == Status::fault);
  CHECK_THAT(report.detail, Catch::Matchers::Contains("mirrored"));
}

TEST_CASE("an answer to another question, or a second one, is none: the next has a new line",
          "[device][t2sa]") {
  const Pose pose{12.5, -7.25, 0.01};
  const std::string p1 = point_line("P1", seen(in_base(kBody[0].at_mm, pose)));
  const std::string p2 = point_line("P2", seen(in_base(kBody[1].at_mm, pose)));
  for (const std::string& wrong : {p2, p1 + p1, p1 + p2}) {
    CAPTURE(wrong);
    Sa sa;
    sa.server.on(Sa::ask("P1"), {{wrong}, {p1}});
    T2saTracker tracker(sa.settings);
    const PoseReport report = tracker.measure(kOccasion);
    CHECK(report.status == Status::timeout);
    CHECK_THAT(report.detail, Catch::Matchers::Contains("nobody asked for"));
    CHECK(tracker.measure(kOccasion).ok());
    CHECK(sa.server.connections() == 2);
  }
  Sa sa;  // for ever: no pose, whatever the triangle of nests
  sa.server.on(Sa::ask("P1"), p2);
  sa.server.on(Sa::ask("P2"), p1);
  T2saTracker tracker(sa.settings);
  for (int k = 0; k < 3; ++k) CHECK(tracker.measure(kOccasion).status == Status::timeout);
}

TEST_CASE("an object's frame must name its group, and be of now", "[device][t2sa]") {
  Sa sa;
  sa.settings.points.clear();
  sa.settings.object_group = "platform";
  const auto says = [&](const char* name, const char* stamp) {
    sa.server.on("?POS platform", fmt::format("ACK-300 Object Offset Report {};X:1;Y:2;Z:3;Rx:0;"
                                              "Ry:0;Rz:0;{}\r\n",
                                              name, stamp));
  };
  sa.server.on("!CMDEXE:platform", "ACK-106 Successfully ran CMD platform\r\n");
  T2saTracker tracker(sa.settings);
  says("FramePLATFORM_1", "11/27/2026 14:00:00");
  CHECK(tracker.measure(kOccasion).ok());
  CHECK(tracker.measure(kOccasion).ok());  // the control: it has not moved
  const Occasion moved{.reading = 2, .time_s = 0, .epoch = 1, .moved_mm = 10};
  CHECK(tracker.measure(moved).status == Status::timeout);
  says("FrameBase_1", "11/27/2026 14:00:01");
  CHECK(tracker.measure(kOccasion).status == Status::timeout);
  says("FramePlatform_1", "99/99/0000 14:00:01");
  CHECK(tracker.measure(kOccasion).status == Status::timeout);
}

TEST_CASE("points that are not of now are none", "[device][t2sa]") {
  Sa sa;
  T2saTracker tracker(sa.settings);
  const Eigen::Vector3d at = seen(in_base(kBody[1].at_mm, {12.5, -7.25, 0.01}));
  REQUIRE(tracker.measure(kOccasion).ok());
  const Occasion moved{.reading = 2, .time_s = 0, .epoch = 1, .moved_mm = 10};
  const PoseReport frozen = tracker.measure(moved);
  CHECK(frozen.status == Status::timeout);
  CHECK_THAT(frozen.detail, Catch::Matchers::Contains("the last one again"));
  CHECK(tracker.measure(moved).status == Status::timeout);  // it stays so
  sa.stand({22.5, -7.25, 0.01});
  CHECK(tracker.measure(moved).ok());
  for (const char* stamp : {"11/27/2026 13:59:58", "11/27/1999 14:00:00", "99/99/0000 14:00:00",
                            "11/27/2026 24:00:00"}) {
    CAPTURE(stamp);
    sa.server.on(Sa::ask("P2"), point_line("P2", at, "True", stamp));
    CHECK(tracker.measure(kOccasion).status == Status::timeout);
  }
}

TEST_CASE("while SA is busy it is asked again", "[device][t2sa]") {
  Sa sa;
  sa.server.on(Sa::ask("P1"),
               {{"ERR-201 Command rejected. SA is busy.\r\n"},
                {point_line("P1", seen(in_base(kBody[0].at_mm, {12.5, -7.25, 0.01})))}});
  CHECK(T2saTracker(sa.settings).measure(kOccasion).ok());
  CHECK(sa.server.count(Sa::ask("P1")) == 2);
}

TEST_CASE("a lost or halved answer times out, and the next measurement has a new line",
          "[device][t2sa]") {
  for (const tests::Answer& fault :
       {tests::Answer{""}, {"ACK-300 Single Point Mea"}, {"", true}, {"ACK-300 Sing", true}}) {
    CAPTURE(fault.bytes, fault.close);
    Sa sa;
    const std::string good = point_line("P2", seen(in_base(kBody[1].at_mm, {12.5, -7.25, 0.01})));
    sa.server.on(Sa::ask("P2"), {fault, {good}});
    T2saTracker tracker(sa.settings);
    const PoseReport report = tracker.measure(kOccasion);
    CHECK(report.status == Status::timeout);
    CHECK(tracker.measure(kOccasion).ok());
    CHECK(sa.server.connections() == 2);
  }
}

TEST_CASE("a beam that breaks while the stage moves is seen by the next question",
          "[device][t2sa]") {
  Sa sa;
  T2saTracker tracker(sa.settings);
  CHECK(tracker.beam() == Status::ok);
  sa.server.on("?STAT", {{"ERR-338 Instrument not ready\r\n"},
                         {"ERR-201 Command rejected. SA is busy.\r\n"},
                         {"ERR-341 Not connected to SA\r\n"},
                         {""}});
  CHECK(tracker.beam() == Status::beam_broken);
  CHECK(tracker.beam() == Status::ok);  // busy measuring
  CHECK(tracker.beam() == Status::fault);
  CHECK(tracker.beam() == Status::timeout);
}

TEST_CASE("a laser that is off is switched on, and one that stays off is told", "[device][t2sa]") {
  Sa sa;
  sa.server.on("?LSTA", {{"ACK-300 LOFF\r\n"}, {"ACK-300 LON\r\n"}});
  sa.server.on("!LST:1", "ACK-300 ACK300\r\n");
  CHECK(T2saTracker(sa.settings).measure(kOccasion).ok());
  CHECK(sa.server.count("!LST:1") == 1);
  sa.settings.warm_up_s = 0.1;
  sa.server.on("?LSTA", "ACK-300 WARM, 12.00 seconds\r\n");
  const PoseReport report = T2saTracker(sa.settings).measure(kOccasion);
  CHECK(report.status == Status::timeout);
  CHECK_THAT(report.detail, Catch::Matchers::Contains("WARM, 12.00 seconds"));
}

TEST_CASE("a tracker that was never reached is a fault", "[device][t2sa]") {
  Sa sa;
  sa.server.vanish();
  CHECK(T2saTracker(sa.settings).measure(kOccasion).status == Status::fault);
}
