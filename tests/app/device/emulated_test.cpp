// Drivers against emulators that were written by others, from the protocols alone.

#include "tests/app/emulate/emulated.hpp"

#include "app/device/galil.hpp"
#include "app/device/t2sa.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::device;
using emulate::FaultKind;

namespace {

/// Both devices with their drivers; waits are short where a test must wait for one to end.
struct Bench {
  tests::EmulatedLaboratory lab;
  std::unique_ptr<GalilStage> stage;
  std::unique_ptr<T2saTracker> tracker;
  Displacements home_mm = Displacements::Zero();

  explicit Bench(double wait_s = 20) {
    GalilSettings s;
    s.controller = {"127.0.0.1", lab.stage_server.port()};
    s.reply_timeout_s = s.margin_s = s.settle_timeout_s = wait_s;
    s.machine = lab.robot.robot().truth().nominal;
    home_mm = drives_of(s.machine, s.machine.home);
    for (int i = 0; i < s.machine.kind->n_chains; ++i) {
      s.axes.push_back({"ABC"[i], 10, 8192, 1, 1, home_mm[i]});
    }
    s.poll_s = 0;
    s.settle_s = 0;
    stage = std::make_unique<GalilStage>(s);
    tracker = std::make_unique<T2saTracker>(tracker_settings(wait_s));
  }

  /// The nests of the emulator's default set-up, the base found by its own.
  [[nodiscard]] T2saSettings tracker_settings(double wait_s) const {
    T2saSettings s;
    s.server = {"127.0.0.1", lab.tracker_server.port()};
    s.reply_timeout_s = wait_s;
    s.nests.sigma_mm = 0.01;
    for (const emulate::Nest& nest : emulate::default_tracker().nests) {
      const std::string address = "A;" + nest.group + ";" + nest.point;
      if (nest.group == "PLATFORM") {
        s.nests.frame.body.push_back({nest.point, nest.at_mm});
        s.points.push_back({nest.point, address});
      } else if (nest.group == "BASE") {
        s.base.push_back({nest.point, nest.at_mm});
        s.base_points.push_back({nest.point, address});
      }
    }
    return s;
  }

  void home() {
    const StageReport report = stage->home();
    INFO(report.detail);
    REQUIRE(report.ok());
  }
  StageReport move(const Displacements& by_mm) {
    return stage->move(home_mm + by_mm, [] { return Status::ok; });
  }
};

const Displacements kThere(20, -12, 6);
constexpr double kCountMm = 10.0 / 8192;
constexpr double kShortWaitS = 0.2;

}  // namespace

TEST_CASE("a homed stage goes where it is sent and the tracker sees it there",
          "[device][emulated]") {
  Bench bench;
  bench.home();
  const StageReport report = bench.move(kThere);
  INFO(report.detail);
  REQUIRE(report.ok());
  CHECK((report.commanded_mm - bench.home_mm - kThere).cwiseAbs().maxCoeff() <=
        kCountMm / 2 + 1e-9);
  CHECK((report.encoder_mm - report.commanded_mm).cwiseAbs().maxCoeff() <= 0.005);
  CHECK(bench.tracker->beam() == Status::ok);
  const PoseReport seen = bench.tracker->measure({});
  INFO(seen.detail);
  REQUIRE(seen.ok());
  // Where the virtual robot says that it stands, within its tracker's noise.
  const emulate::Standing standing = bench.lab.robot.standing();
  const simulate::VirtualRobot& robot = bench.lab.robot.robot();
  const MachinePose truly = robot.read({.cmd_mm = standing.l_mm,
                                        .from_mm = standing.from_mm,
                                        .epoch = standing.epoch,
                                        .time_s = standing.time_s,
                                        .temp_degc = {}},
                                       1);
  REQUIRE(truly.ok());
  constexpr double kSixSigmaMm = 6 * 0.02;  // of the base, the nests and robot.read's own noise
  CHECK(std::abs(seen.pose.x_mm - truly.pose.x_mm) < kSixSigmaMm);
  CHECK(std::abs(seen.pose.y_mm - truly.pose.y_mm) < kSixSigmaMm);
  CHECK(std::abs(seen.pose.phi_rad - truly.pose.phi_rad) < 6 * rad_from_deg(0.06));
}

TEST_CASE("the platform measured as an object stands where its nests stand, asked for either way",
          "[device][emulated]") {
  Bench bench;
  bench.home();
  REQUIRE(bench.move(kThere).ok());
  const PoseReport nests = bench.tracker->measure({});
  REQUIRE(nests.ok());
  for (const bool by_offset : {false, true}) {
    CAPTURE(by_offset);
    T2saSettings settings = bench.tracker_settings(20);
    settings.base.clear();
    settings.object_group = "PLATFORM";
    if (by_offset) {
      settings.object_reference = "BASE";
    } else {
      settings.nests.frame.T_B_T = emulate::default_tracker().from_base.inverse();
    }
    const PoseReport object = T2saTracker(settings).measure({});
    INFO(object.detail);
    REQUIRE(object.ok());
    CHECK(std::abs(object.pose.x_mm - nests.pose.x_mm) < 6 * 0.02);
    CHECK(std::abs(object.pose.y_mm - nests.pose.y_mm) < 6 * 0.02);
    CHECK(std::abs(object.pose.phi_rad - nests.pose.phi_rad) < 6 * rad_from_deg(0.06));
  }
}

TEST_CASE("whichever line is lost, halved or dropped, a second try gets there",
          "[device][emulated]") {
  constexpr std::array<FaultKind, 3> kKinds = {FaultKind::dropped, FaultKind::half_reply,
                                               FaultKind::lost_reply};
  Bench bench(kShortWaitS);
  bench.home();
  int unknown = 0, met = 0;
  for (std::uint64_t line = 1; line <= 60; ++line) {
    const FaultKind kind = kKinds[line % 7 == 0 ? 2 : line % 2];  // silence costs time
    CAPTURE(line, emulate::name_of(kind));
    const int before = bench.lab.stage_faults.struck(kind);
    bench.lab.stage_faults.add({kind, line, ""});
    const Displacements to = line % 2 == 1 ? kThere : Displacements(0, 0, 0);
    StageReport report = bench.move(to);
    if (!report.ok()) {
      ++unknown;
      CHECK(report.status == Status::timeout);
      CHECK_THAT(report.detail, Catch::Matchers::Contains("unknown"));
      report = bench.move(to);
    }
    INFO(report.detail);
    REQUIRE(report.ok());
    if (bench.lab.stage_faults.struck(kind) == before) break;  // the move has no more lines
    ++met;
    CHECK((report.encoder_mm - bench.home_mm - to).cwiseAbs().maxCoeff() <= 0.006);
  }
  CHECK(met >= 25);
  CHECK(unknown >= met - 1);  // a fault on a stop's own answer would be met within the stop
}

TEST_CASE("a limit, a dead amplifier and a stalled motor stop the stage, each with its name",
          "[device][emulated]") {
  struct Case {
    FaultKind kind;
    Status status;
    const char* words;
    bool homed;
  };
  for (const Case& c : {Case{FaultKind::limit_hit, Status::limit, "limit", true},
                        {FaultKind::amplifier_fault, Status::fault, "amplifier fault", false},
                        // whoever sees it first: we, or the controller's own limit
                        {FaultKind::stall, Status::following_error, "rail 1", false}}) {
    CAPTURE(c.words);
    Bench bench;
    bench.home();
    bench.lab.stage_faults.add_next(c.kind);
    const StageReport report = bench.move(kThere);
    CHECK(report.status == c.status);
    CHECK_THAT(report.detail, Catch::Matchers::Contains(c.words));
    CHECK(bench.lab.stage_faults.struck(c.kind) == 1);
    CHECK(bench.stage->homed() == c.homed);
    CHECK_FALSE(bench.lab.robot.standing().moving);
    bench.home();
    CHECK(bench.move(kThere).ok());
  }
}

TEST_CASE("a beam that is lost on the way stops the stage at the next sample",
          "[device][emulated]") {
  Bench bench;
  bench.home();
  REQUIRE(bench.tracker->beam() == Status::ok);
  bench.lab.tracker_faults.add_next(FaultKind::beam_lost);
  const StageReport report =
      bench.stage->move(bench.home_mm + kThere, [&] { return bench.tracker->beam(); });
  CHECK(report.status == Status::beam_broken);
  CHECK_FALSE(bench.lab.robot.standing().moving);
  CHECK(bench.move(kThere).ok());
}

TEST_CASE("what the tracker cannot measure is told, and measured the next time",
          "[device][emulated]") {
  Bench bench(1);
  bench.home();
  REQUIRE(bench.tracker->measure({}).ok());
  struct Case {
    FaultKind kind;
    Status status;
  };
  for (const Case& c : {Case{FaultKind::beam_break, Status::beam_broken},
                        {FaultKind::unstable, Status::unstable},
                        {FaultKind::dropped, Status::timeout},
                        {FaultKind::half_reply, Status::timeout},
                        {FaultKind::lost_reply, Status::timeout}}) {
    CAPTURE(emulate::name_of(c.kind));
    bench.lab.tracker_faults.add({c.kind, 2, ""});
    const PoseReport report = bench.tracker->measure({});
    INFO(report.detail);
    CHECK(report.status == c.status);
    CHECK(bench.lab.tracker_faults.struck(c.kind) == 1);
    const PoseReport again = bench.tracker->measure({});
    INFO(again.detail);
    CHECK(again.ok());
  }
}
