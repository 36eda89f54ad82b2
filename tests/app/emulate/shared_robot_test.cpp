// Moving the emulated stage moves what the emulated tracker sees.

#include <cmath>

#include "app/emulate/stage_link.hpp"
#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "tests/app/emulate/client.hpp"
#include "tests/app/emulate/emulated.hpp"
#include "tests/support/catch.hpp"

namespace trammel::emulate {

using tests::Client;
using tests::EmulatedLaboratory;

namespace {

const std::vector<Pose> kTargets = {{30, 10, 0.02}, {-20, 25, -0.04}, {0, -40, 0}, {15, 0, 0.1}};

Displacements displacements(const Pose& pose) {
  const InverseResult there = inverse(paper_mechanism().geometry, pose);
  REQUIRE(there.ok());
  return there.l_mm;
}

/// Counts from home, as a driver of the example screws sends them.
void go_to(Client& stage, const Pose& pose) {
  const Displacements way = displacements(pose) - displacements({});
  std::string line;
  for (int i = 0; i < kChains; ++i) {
    line += "PA" + std::string(1, static_cast<char>('A' + i)) + "=" +
            std::to_string(std::lrint(way[i] * 819.2)) + ";";
  }
  REQUIRE(stage.galil(line + "BGABC", 4) == "::::");
  stage.until_at_rest();
}

/// The replies of a small campaign.
std::vector<std::string> campaign(int stage_port, int tracker_port) {
  Client stage(stage_port), tracker(tracker_port);
  stage.galil("SHABC;SP 16384,16384,16384", 2);
  std::vector<std::string> replies;
  for (const Pose& target : kTargets) {
    go_to(stage, target);
    for (const char* ask :
         {"!CMDEXE:PLATFORM", "?OFFSET:PLATFORM;BASE", "!MEAS_SINGLE_POINT:A;PAIR;P1"}) {
      replies.push_back(tracker.tracker(ask));
    }
  }
  return replies;
}

}  // namespace

TEST_CASE("the tracker sees the platform where the stage has moved it, effects and all",
          "[emulate]") {
  simulate::Truth truth = tests::emulated_truth();
  truth.tracker.sigma_xy_mm = truth.tracker.sigma_phi_rad = 0;
  truth.temperature.rise_k = 0;
  EmulatedLaboratory lab(truth);
  Client stage(lab.stage_server.port()), tracker(lab.tracker_server.port());
  stage.galil("SHABC");
  Displacements from = displacements({});
  for (const Pose& target : kTargets) {
    go_to(stage, target);
    tracker.tracker("!CMDEXE:PLATFORM");
    const std::string reply = tracker.tracker("?OFFSET:PLATFORM;BASE");
    double x = 0, y = 0, rz = 0;
    REQUIRE(std::sscanf(reply.c_str(),
                        "ACK-300 Object Offset Report FramePLATFORM_1;X:%lf;Y:%lf;Z:%*f;"
                        "Rx:%*f;Ry:%*f;Rz:%lf;",
                        &x, &y, &rz) == 3);
    const Displacements l = displacements(target);
    const Pose expected =
        lab.robot.robot()
            .seen_pose({.cmd_mm = l, .from_mm = from, .epoch = 1, .time_s = 0.0, .temp_degc = 20.0})
            .pose;
    from = l;
    constexpr double kCount = 2e-3;  // half a count of each of three rails
    CHECK_THAT(x, WithinAbs(expected.x_mm, kCount));
    CHECK_THAT(y, WithinAbs(expected.y_mm, kCount));
    CHECK_THAT(rz, WithinAbs(deg_from_rad(expected.phi_rad), 2e-3));
    CHECK(std::hypot(x - target.x_mm, y - target.y_mm) > 0.02);  // the hidden effects are there
  }
}

TEST_CASE("the same moves and measurements give the same bytes, however fast they came",
          "[emulate]") {
  EmulatedLaboratory first, second;
  const auto replies = campaign(first.stage_server.port(), first.tracker_server.port());
  CHECK(replies == campaign(second.stage_server.port(), second.tracker_server.port()));
  for (const std::string& reply : replies) CHECK(reply.starts_with("ACK-"));
}

TEST_CASE("a tracker that asks the stage over its socket sees what one beside it sees",
          "[emulate]") {
  EmulatedLaboratory lab, other;
  Faults faults;
  const std::string address = "127.0.0.1:" + std::to_string(other.stage_server.port());
  EmulatedTracker apart(
      other.robot.robot(), default_tracker(), [&address] { return ask_standing(address); }, faults,
      EmulatedLaboratory::kSpeedup);
  const Server server({}, tracker_conversations(apart, faults));
  CHECK(campaign(lab.stage_server.port(), lab.tracker_server.port()) ==
        campaign(other.stage_server.port(), server.port()));
}

TEST_CASE("a tracker does not measure a platform that moves", "[emulate]") {
  EmulatedLaboratory lab;
  Client stage(lab.stage_server.port()), tracker(lab.tracker_server.port());
  stage.galil("SHABC;SPA=2;PAA=80000", 3);
  stage.galil("BGA");  // 40000 s there, 2 s here
  CHECK_THAT(tracker.tracker("!MEAS_SINGLE_POINT:A;PAIR;P1"), Contains("ERR-305"));
  stage.galil("STA");
  stage.until_at_rest("A");
  CHECK_THAT(tracker.tracker("!MEAS_SINGLE_POINT:A;PAIR;P1"), Contains("ACK-300"));
}

TEST_CASE("each homing is an epoch of its own, and homes lie where the truth puts them",
          "[emulate]") {
  simulate::Truth truth = tests::emulated_truth();
  truth.epochs = {{}, {.l_zero_mm = {0.2, 0, 0}, .frame = {}}};
  EmulatedLaboratory lab(truth);
  Client stage(lab.stage_server.port());
  stage.galil("SHABC");
  for (const int epoch : {1, 2, 3}) {
    stage.galil("HMABC;BGABC", 2);
    stage.until_at_rest();
    CHECK(stage.galil("SCA") == " 10\r\n:");
    CHECK(lab.robot.standing().epoch == epoch);
  }
}

TEST_CASE("a standing survives its way over the line, and nonsense does not", "[emulate]") {
  Standing standing;
  standing.l_mm = {1.0 / 3, -2e-7, 123.456789012345678};
  standing.from_mm = {0.1, 0.2, 0.3};
  standing.epoch = 3;
  standing.time_s = 1234.5678901234567;
  standing.moving = true;
  CHECK(parse_standing(standing_text(standing)) == standing);
  CHECK_THROWS_AS(parse_standing("1 2 3"), DeviceError);
  CHECK_THROWS_AS(parse_standing("1 2 3 1 2 3 1e300 0 0"), DeviceError);
  CHECK_THROWS_AS(parse_standing("1 2 3 1 2 3 1 1e300 0"), DeviceError);
  CHECK_THROWS_AS(ask_standing("nowhere"), UsageError);
  CHECK_THROWS_WITH(ask_standing("127.0.0.1:1"), Contains("emulate galil"));
}

}  // namespace trammel::emulate
