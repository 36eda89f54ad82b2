// Every fault at every point of a short campaign, over sockets: emulators that know nothing of the
// drivers, the drivers, the runner and a database on disk.

#include <array>

#include "tests/app/session/socket_campaign.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;
using device::Status;
using emulate::Emulated;
using emulate::FaultKind;

namespace {

constexpr int kSocketPoints = 3;

Plan socket_plan() {
  Plan plan = small_plan();
  plan.points.resize(kSocketPoints);
  return plan;
}

/// A fault by the occasion it strikes at, and what the try that meets it ends with.
struct WireFault {
  const char* name;
  Emulated where;
  emulate::Fault fault;
  Status status;
};

const std::vector<WireFault>& wire_faults() {
  constexpr Emulated kStage = Emulated::stage, kTracker = Emulated::tracker;
  static const std::vector<WireFault> all = {
      {"the answer to a begin is lost",
       kStage,
       {FaultKind::lost_reply, 1, "BGABC"},
       Status::timeout},
      {"half of the answer to a poll", kStage, {FaultKind::half_reply, 1, "TEA"}, Status::timeout},
      {"the controller drops the line", kStage, {FaultKind::dropped, 1, "PAB="}, Status::timeout},
      {"it drops the line when it is asked where it stands",
       kStage,
       {FaultKind::dropped, 1, "TPA"},
       Status::timeout},
      {"a limit", kStage, {FaultKind::limit_hit}, Status::limit},
      {"an amplifier fault", kStage, {FaultKind::amplifier_fault}, Status::fault},
      {"a stall", kStage, {FaultKind::stall}, Status::following_error},
      {"the answer of a measurement is lost",
       kTracker,
       {FaultKind::lost_reply, 1, "M;P2"},
       Status::timeout},
      {"half of the answer of a measurement",
       kTracker,
       {FaultKind::half_reply, 1, "M;P3"},
       Status::timeout},
      {"the tracker drops the line", kTracker, {FaultKind::dropped, 1, "M;P1"}, Status::timeout},
      {"it drops the line while the stage moves",
       kTracker,
       {FaultKind::dropped, 2, "?STAT"},
       Status::timeout},
      {"the beam is broken while measuring",
       kTracker,
       {FaultKind::beam_break, 2, ""},
       Status::beam_broken},
      {"the beam is lost while the stage moves",
       kTracker,
       {FaultKind::beam_lost, 2, ""},
       Status::beam_broken},
      {"an unstable reading", kTracker, {FaultKind::unstable, 3, ""}, Status::unstable},
  };
  return all;
}

/// The point of the nests' group in `only` above.
emulate::Fault full_name(emulate::Fault fault) {
  if (fault.only.starts_with("M;")) fault.only = "PLATFORM" + fault.only.substr(1);
  return fault;
}

/// After each line that a fault befell, and before the beam is asked for again or anything begins:
/// is the stage told to stop?
bool stopped_within_a_sample(const std::vector<WireLog::Line>& lines) {
  for (auto line = lines.begin(); line != lines.end(); ++line) {
    if (!line->struck) continue;
    for (++line; line != lines.end() && !line->text.starts_with("ST"); ++line) {
      if (line->to == Emulated::tracker || line->text.starts_with("BG")) return false;
    }
    if (line == lines.end()) return false;
  }
  return true;
}

/// Whatever an instrument says of a point, that it accepts it.
void always_accepted(std::string& answer) {
  const std::size_t at = answer.find("False");
  if (at != std::string::npos) answer.replace(at, 5, "True");
}

/// A tracker whose driver asks for the beam and does not listen.
class CarelessTracker : public device::Tracker {
 public:
  explicit CarelessTracker(std::unique_ptr<Tracker> real) : real_(std::move(real)) {}
  [[nodiscard]] std::string describe() const override { return real_->describe(); }
  [[nodiscard]] Status beam() override {
    static_cast<void>(real_->beam());
    return Status::ok;
  }
  device::PoseReport measure(const device::Occasion& occasion) override {
    return real_->measure(occasion);
  }

 private:
  std::unique_ptr<Tracker> real_;
};

}  // namespace

TEST_CASE(
    "over sockets every fault at every point is tried again or ends the session, and a resume "
    "leaves each point stored once, as the robot really stood",
    "[session][sockets]") {
  for (const WireFault& fault : wire_faults()) {
    for (int at = 1; at <= kSocketPoints; ++at) {
      CAPTURE(fault.name, at);
      SocketCampaign campaign(socket_plan());
      campaign.arm(at, fault.where, full_name(fault.fault));
      const Outcome outcome = campaign.run();
      INFO(outcome.detail);
      REQUIRE(campaign.struck() == 1);
      std::vector<std::string> failed;  // at this point
      for (const store::Attempt& a : campaign.attempts()) {
        if (a.point_seq == at && a.status == "failed") failed.push_back(a.detail);
      }
      REQUIRE(!failed.empty());
      CHECK_THAT(failed.front(), Catch::StartsWith(device::name_of(fault.status)));
      if (tries_for(fault.status) > 1) {
        CHECK(outcome.state == State::done);
      } else {
        CHECK(outcome.state == State::faulted);
        CHECK(outcome.exit_code() == ExitCode::device);
        CHECK(outcome.n_stored == at - 1);
        CHECK(campaign.problems(false).empty());
        if (fault.status == Status::limit) campaign.free_rails();
        const Outcome resumed = campaign.run();
        INFO(resumed.detail);
        CHECK(resumed.state == State::done);
      }
      const auto problems = campaign.problems();
      CAPTURE(problems);
      CHECK(problems.empty());
    }
  }
}

TEST_CASE(
    "over sockets a beam that is lost at a sample stops the stage before the next, and no invalid "
    "reading is stored",
    "[session][sockets]") {
  int samples = 0;
  {
    SocketCampaign calm(socket_plan());
    REQUIRE(calm.run().state == State::done);
    CHECK(calm.problems().empty());
    samples = calm.lab.log.count("?STAT");
  }
  CHECK(samples > 10 * kSocketPoints);
  constexpr int kSampleStride = 7;
  int on_the_way = 0;
  for (int at = 1; at <= samples; at += kSampleStride) {
    CAPTURE(at);
    SocketCampaign campaign(socket_plan());
    campaign.lab.tracker_faults.add({FaultKind::beam_lost, static_cast<std::uint64_t>(at), ""});
    CHECK(campaign.run().state == State::done);
    REQUIRE(campaign.struck() == 1);
    CHECK(stopped_within_a_sample(campaign.lab.log.lines()));
    for (const store::Attempt& a : campaign.attempts()) {
      on_the_way += a.detail.find("stopped while moving") != std::string::npos ? 1 : 0;
    }
    CHECK(campaign.problems().empty());
  }
  CHECK(on_the_way > samples / kSampleStride / 3);  // the control: they do hit moves

  // The control: a driver that does not listen is caught by the same look at the wire.
  SocketCampaign careless(socket_plan());
  careless.altered = [](device::Devices& devices) {
    devices.tracker = std::make_unique<CarelessTracker>(std::move(devices.tracker));
  };
  careless.lab.tracker_faults.add({FaultKind::beam_lost, 9, ""});
  CHECK(careless.run().state == State::done);
  CHECK_FALSE(stopped_within_a_sample(careless.lab.log.lines()));
}

TEST_CASE("a beam broken at any measurement of a campaign leaves no reading of it",
          "[session][sockets]") {
  constexpr std::uint64_t kMeasurements = 3 + 3 * kSocketPoints;  // of base and platform
  for (std::uint64_t at = 1; at <= kMeasurements; ++at) {
    CAPTURE(at);
    SocketCampaign campaign(socket_plan());
    campaign.lab.tracker_faults.add({FaultKind::beam_break, at, ""});
    CHECK(campaign.run().state == State::done);
    CHECK(campaign.lab.tracker_faults.struck(FaultKind::beam_break) == 1);
    CHECK(campaign.problems().empty());
  }
}

TEST_CASE("an instrument that accepts what is unstable is caught by the look at what is stored",
          "[session][sockets]") {
  // The control of all tests here: what they call a problem is seen where nothing refuses it.
  SocketOptions blind;
  blind.blind = true;
  SocketCampaign campaign(socket_plan(), blind);
  campaign.lab.to_tracker.alter = &always_accepted;
  for (std::uint64_t nest = 1; nest <= 3; ++nest) {
    campaign.lab.tracker_faults.add({FaultKind::unstable, 3 + 3 + nest, ""});  // of point 2
  }
  CHECK(campaign.run().state == State::done);
  CHECK(campaign.struck() == 3);
  CHECK(campaign.problems().size() == 1);

  SocketCampaign rigid(socket_plan());  // and with them it is refused, whatever was said of it
  rigid.lab.to_tracker.alter = &always_accepted;
  rigid.arm(2, Emulated::tracker, {FaultKind::unstable, 1, ""});
  CHECK(rigid.run().state == State::done);
  CHECK(rigid.problems().empty());
}

}  // namespace trammel::session
