// A tracker that drifts while a campaign is measured through sockets, and one that does not.

#include "app/session/base_check.hpp"

#include "app/session/status.hpp"
#include "app/session/wishes.hpp"
#include "tests/app/session/socket_campaign.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;

namespace {

/// Sixteen points, the base looked at after each two, under a tracker that drifts along x.
struct Drifting {
  SocketCampaign campaign;

  explicit Drifting(double mm_per_h) : campaign(small_plan(), options(mm_per_h)) {
    campaign.request.policy.base_every = 2;
    campaign.request.policy.patience_s = 90;
  }
  static SocketOptions options(double mm_per_h) {
    SocketOptions options;
    options.truth.tracker.drift_per_h.x_mm = mm_per_h;
    return options;
  }
  SessionStatus status() {
    return status_of(campaign.db, store::require_campaign(campaign.db, "c"), "s", std::nullopt);
  }
  std::vector<std::string> kinds() {
    const auto owner = store::require_campaign(campaign.db, "c");
    std::vector<std::string> kinds;
    for (const auto& e :
         store::events(campaign.db, store::find_session(campaign.db, owner.id, "s")->id)) {
      if (e.kind != "walk" && e.kind != kBaseEvent) kinds.push_back(e.kind);
    }
    return kinds;
  }
};

using Kinds = std::vector<std::string>;

}  // namespace

TEST_CASE("base nests that stand still raise no alarm, and what was found is on record",
          "[session][sockets]") {
  Drifting still(0);
  CHECK(still.campaign.run().state == State::done);
  CHECK(still.kinds() == Kinds{"checked", "started", "done"});
  const SessionStatus status = still.status();
  REQUIRE(status.base.size() == 8);  // after 2, 4, … 14 and the last
  for (const auto& b : status.base) {
    CHECK_FALSE(b.check.moved);
    CHECK(b.check.moved_mm > 0);  // they are measured: noise is seen
    CHECK(b.check.moved_mm < b.check.chance_mm);
  }
  CHECK(status.base.front().check.after == 2);
  CHECK(status.base.back().check.after == 16);
  CHECK_THAT(status_text(status), Contains("base nests") && !Contains("more than chance"));
  CHECK(status_json(status).at("base").size() == 8);
}

TEST_CASE("a tracker that drifts beyond the gate suspends the session, which ends when it stays so",
          "[session][sockets]") {
  Drifting drifting(4);
  const Outcome outcome = drifting.campaign.run();
  CHECK(outcome.exit_code() == ExitCode::interrupted);
  CHECK_THAT(outcome.detail, Contains("base nest B") && Contains("has moved"));
  CHECK(outcome.n_stored > 1);
  CHECK(outcome.n_stored < 16);
  CHECK_THAT(outcome.detail, Contains("excluded: readings"));  // those since the look before
  CHECK(drifting.campaign.excluded().size() <= 2);
  CHECK(drifting.kinds() == Kinds{"checked", "started", "paused", "stopped"});
  const SessionStatus status = drifting.status();
  REQUIRE(!status.base.empty());
  const BaseCheck& last = status.base.back().check;
  CHECK(last.off);
  CHECK_THAT(last.shift.x_mm, WithinAbs(last.moved_mm, 0.05));  // along x it is, as told
  CHECK(std::abs(last.shift.y_mm) < 0.05);
  CHECK_THAT(status_text(status), Contains("beyond the gate"));
}

TEST_CASE("a drift within the gate is on record and stops nothing", "[session][sockets]") {
  Drifting slow(4);
  slow.campaign.request.policy.drift_mm = 5;
  CHECK(slow.campaign.run().state == State::done);
  const SessionStatus status = slow.status();
  CHECK(status.base.back().check.moved);
  CHECK_FALSE(status.base.back().check.off);
  CHECK_THAT(status_text(status), Contains("more than chance"));
}

TEST_CASE("a suspended session stops at once when another process asks for it",
          "[session][sockets]") {
  Drifting drifting(4);
  drifting.campaign.request.policy.patience_s = 1e6;
  int slept = 0, asked_at = -1;
  drifting.campaign.around.sleep = [&](double) {
    ++slept;
    if (drifting.kinds().back() != "paused" || asked_at >= 0) return;
    asked_at = slept;
    store::Connection other = store::open(drifting.campaign.db.file(), store::Access::write);
    const auto owner = store::require_campaign(other, "c");
    ask(other, store::find_session(other, owner.id, "s")->id, Wish::stop);
  };
  const Outcome outcome = drifting.campaign.run();
  CHECK(outcome.exit_code() == ExitCode::interrupted);
  CHECK_THAT(outcome.detail, Contains("by the operator"));
  REQUIRE(asked_at > 0);
  CHECK(slept == asked_at);  // not one slice more of its patience
}

TEST_CASE("asked to go on, a suspended session sets up anew and registers the frame anew",
          "[session][sockets]") {
  Drifting drifting(1.5);
  drifting.campaign.request.policy.patience_s = 1e6;
  int asked = 0;
  drifting.campaign.around.sleep = [&](double) {
    if (drifting.kinds().back() != "paused") return;
    store::Connection other = store::open(drifting.campaign.db.file(), store::Access::write);
    const auto owner = store::require_campaign(other, "c");
    ask(other, store::find_session(other, owner.id, "s")->id, Wish::go_on);
    REQUIRE(++asked < 16);
  };
  const Outcome outcome = drifting.campaign.run();
  INFO(outcome.detail);
  // All points are stored; the drift goes on, and the look after the last one may find it again.
  if (outcome.state != State::done) CHECK_THAT(outcome.detail, Contains("after the last point"));
  CHECK(asked > 0);
  CHECK(drifting.status().epoch == 1 + asked);
}

TEST_CASE("a beam that breaks at a base nest is tried again, and no reading is touched",
          "[session][sockets]") {
  Drifting still(0);
  // Base at the first reading, two points, then the second look at B2.
  still.campaign.lab.tracker_faults.add({emulate::FaultKind::beam_break, 2, "B2"});
  CHECK(still.campaign.run().state == State::done);
  CHECK(still.campaign.struck() == 1);
  CHECK(still.status().base.size() == 8);
  for (const auto& a : still.campaign.attempts()) CHECK(a.status == "ok");
  CHECK(still.campaign.problems().empty());
}

TEST_CASE("a tracker without base nests is refused before anything moves", "[session][sockets]") {
  SocketOptions stated;
  stated.base_nests = false;
  SocketCampaign campaign(small_plan(), stated);
  campaign.request.policy.base_every = 2;
  CHECK_THROWS_WITH(campaign.run(), Contains("base nests") && Contains("--base-every"));
  CHECK_FALSE(store::find_campaign(campaign.db, "c"));
  CHECK(campaign.lab.log.lines().empty());
  campaign.request.policy.base_every = -1;
  CHECK_THROWS_AS(campaign.run(), UsageError);
}

TEST_CASE("a virtual tracker's drift is seen by its base nests, and looking at them changes no bit",
          "[session]") {
  const TemporaryFolder folder;
  auto robot = nlohmann::json::parse(read_text(kPaperRobot));
  robot["tracker"]["drift_x_mm_h"] = 4;
  const std::string drifting = "sim:" + folder.write("robot.json", robot.dump()).string();
  const auto measured = [&](const std::string& name, const std::string& stage, int every) {
    Request request = request_for(small_plan());
    request.stage = stage;
    request.policy.base_every = every;
    store::Connection db = store::open(folder.path() / name, store::Access::create);
    const Outcome outcome = run(db, request, {});
    return std::pair(outcome, by_point(db, "c", "s"));
  };
  const auto [plain, readings] = measured("plain.db", "sim:" + kPaperRobot, 0);
  const auto [still, looked] = measured("looked.db", "sim:" + kPaperRobot, 2);
  CHECK(still.state == State::done);
  REQUIRE(looked.size() == readings.size());
  for (const auto& [seq, reading] : readings) CHECK(same_bits(reading, looked.at(seq)));
  const auto [moved, few] = measured("moved.db", drifting, 2);
  CHECK(moved.exit_code() == ExitCode::interrupted);
  CHECK_THAT(moved.detail, Contains("base nest B"));
  CHECK(few.size() < readings.size());
}

}  // namespace trammel::session
