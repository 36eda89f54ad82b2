// A proxy between the program and its devices that renames, holds back, freezes, doubles, shifts:
// what it makes of a reading is not stored.

#include <algorithm>
#include <atomic>

#include "tests/app/session/proxies.hpp"
#include "tests/app/session/socket_campaign.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;

namespace {

constexpr int kProxied = 4;  // points

Plan proxied_plan(std::size_t n = kProxied) {
  Plan plan = small_plan();
  plan.points.resize(n);
  return plan;
}

}  // namespace

TEST_CASE("an answer of another point, of another time or of the pose before is never stored",
          "[session][sockets]") {
  struct Case {
    const char* name;
    Alter alter;
    int most;  // points that may be stored
  };
  for (const Case& c : {Case{"renamed", from_pose(2, renaming()), 1},
                        {"lagging", lagging(), kProxied - 1},
                        {"lagging, but for the last digit", lagging_unlike(), 1},
                        {"frozen", frozen(), 1},
                        {"of 1999", from_pose(3, dated("11/27/1999")), 2},
                        {"of no day", from_pose(3, dated("99/99/0000")), 2}}) {
    CAPTURE(c.name);
    SocketCampaign campaign(proxied_plan());
    campaign.lab.to_tracker.alter = c.alter;
    const Outcome outcome = campaign.run();
    CAPTURE(outcome.detail);
    CHECK(outcome.state == State::faulted);
    CHECK(outcome.n_stored <= c.most);
    const auto problems = campaign.problems(false);
    CAPTURE(problems);
    CHECK(problems.empty());
  }
  SocketCampaign open(proxied_plan());  // the control: what lets a pose pass stores a wrong one
  open.lab.to_tracker.alter = [lag = lagging(), n = 0](std::string& answer) mutable {
    lag(answer);
    shift(answer, 1e-6 * ++n);  // so that no answer is the last one again
    answer = std::regex_replace(answer, std::regex("\\d\\d/\\d\\d/\\d{4} \\d\\d:\\d\\d:\\d\\d"),
                                "01/05/2026 08:00:00");
  };
  open.request.policy.gate_mm = 1e3;
  const Outcome passed = open.run();
  CAPTURE(passed.detail);
  CHECK_FALSE(open.problems(false).empty());
}

TEST_CASE("of steps below a millimetre, too, no answer of the pose before is stored",
          "[session][sockets]") {
  Plan fine = proxied_plan(1);
  for (int k = 1; k < kProxied; ++k) {
    fine.points.push_back(fine.points.front());
    fine.points.back().seq = k + 1;
    fine.points.back().target.x_mm += 0.4 * k;
  }
  for (const bool lags : {true, false}) {  // the control: each is stored
    CAPTURE(lags);
    SocketCampaign campaign(fine);
    campaign.request.policy.patience_s = 30;
    if (lags) campaign.lab.to_tracker.alter = lagging_unlike();
    const Outcome outcome = campaign.run();
    CAPTURE(outcome.detail);
    CHECK((outcome.state == State::done) == !lags);
    CHECK((outcome.n_stored == kProxied) == !lags);
    const auto problems = campaign.problems(false);
    CAPTURE(problems);
    CHECK(problems.empty());
  }
}

TEST_CASE("answers that come twice for ever end the session after three tries",
          "[session][sockets]") {
  for (const bool measured : {true, false}) {  // else what is asked while the stage moves
    CAPTURE(measured);
    SocketCampaign campaign(proxied_plan());
    const auto twice = [](std::string& answer) { answer += answer; };
    if (measured) {
      campaign.lab.to_tracker.alter = twice;
    } else {
      campaign.lab.to_tracker.alter_asked = [twice](std::string_view asked, std::string& answer) {
        if (asked.starts_with("?STAT")) twice(answer);
      };
    }
    const Outcome outcome = campaign.run();
    CAPTURE(outcome.detail);
    CHECK(outcome.exit_code() == ExitCode::device);
    CHECK_THAT(outcome.detail, Contains("try 3 of 3"));
    CHECK(outcome.n_stored == 0);
    CHECK(campaign.attempts().size() == 3);
    CHECK_FALSE(campaign.lab.robot.standing().moving);
  }
}

TEST_CASE("an answer that comes twice costs a try, not the session", "[session][sockets]") {
  for (const char* point : {"P1", "P2", "P3"}) {
    CAPTURE(point);
    SocketCampaign campaign(proxied_plan());
    campaign.lab.to_tracker.alter = [point, n = 0](std::string& answer) mutable {
      if (point_of(answer) == point && ++n == 2) answer += answer;
    };
    const Outcome outcome = campaign.run();
    CAPTURE(outcome.detail);
    CHECK(outcome.state == State::done);
    CHECK(campaign.problems().empty());
    const auto attempts = campaign.attempts();
    CHECK(std::ranges::count_if(attempts,
                                [](const store::Attempt& a) { return a.status == "failed"; }) == 1);
  }
}

TEST_CASE("a rail that stands elsewhere than its command is no place to measure",
          "[session][sockets]") {
  for (const int off : {8192, 1}) {  // a turn of the screw; a count, the control
    CAPTURE(off);
    SocketCampaign campaign(proxied_plan());
    campaign.lab.to_stage.alter_asked = [off, &campaign](std::string_view asked,
                                                         std::string& answer) {
      if (!asked.starts_with("TPA") || campaign.lab.log.count("!MEAS") < 8) return;
      const auto counts = std::stol(answer) + off;
      answer = fmt::format(" {}{}", counts, answer.substr(answer.find('\r')));
    };
    const Outcome outcome = campaign.run();
    CAPTURE(outcome.detail);
    if (off == 1) {
      CHECK(outcome.state == State::done);
      continue;
    }
    CHECK(outcome.exit_code() == ExitCode::device);
    CHECK_THAT(outcome.detail, Contains("encoder of rail 1 is") && Contains("at rest"));
    CHECK(outcome.n_stored < kProxied);
    CHECK(campaign.problems(false).empty());
  }
}

TEST_CASE("a tracker that is knocked is noticed, in the middle and at the end",
          "[session][sockets]") {
  {
    SocketCampaign campaign(small_plan());  // sixteen points
    campaign.request.policy.patience_s = 30;
    campaign.lab.to_tracker.alter = knocked(10, 2);
    const Outcome outcome = campaign.run();
    CAPTURE(outcome.detail);
    CHECK(outcome.state == State::stopped);
    CHECK_THAT(outcome.detail, Contains("has moved"));
    CHECK(outcome.n_stored == 9);
    CHECK(campaign.problems(false).empty());
  }
  {
    SocketCampaign without(small_plan(), {.base_nests = false});
    without.request.policy.patience_s = 30;
    without.lab.to_tracker.alter = knocked(10, 2);
    const Outcome outcome = without.run();
    CAPTURE(outcome.detail);
    CHECK(outcome.state == State::stopped);
    CHECK_THAT(outcome.detail, Contains("a step of") && Contains("measured again"));
    CHECK(outcome.n_stored == 9);
  }
  for (const double by_mm : {2.0, 0.01}) {  // the control: within noise
    CAPTURE(by_mm);
    SocketCampaign few(proxied_plan(3));  // too few to know how deviations differ
    few.lab.to_tracker.alter = knocked(2, by_mm);
    const Outcome outcome = few.run();
    CAPTURE(outcome.detail);
    CHECK(outcome.exit_code() == (by_mm > 1 ? ExitCode::safety_stop : ExitCode::ok));
    if (by_mm < 1) continue;
    CHECK_THAT(outcome.detail, Contains("base nest") && Contains("in doubt"));
    // The tracker stands where it was knocked to, and is registered there: the points are not.
    const Outcome again = few.run();
    CAPTURE(again.detail);
    CHECK(again.exit_code() == ExitCode::safety_stop);
    CHECK_THAT(again.detail, Contains("reading exclude") && Contains("measured again"));
    const auto campaign = store::require_campaign(few.db, "c");
    const store::Id session = store::find_session(few.db, campaign.id, "s")->id;
    for (const store::StoredReading& r : store::readings(few.db, campaign.id, {session})) {
      if (r.data.reading.seq > 1) {
        store::exclude_reading(few.db, campaign.id, r.data.reading.seq, "of a knocked tracker");
      }
    }
    CHECK(few.run().state == State::done);
  }
  SocketCampaign after(proxied_plan(3));  // knocked when all was measured: no point is in doubt
  std::atomic<bool> put_back = false;
  after.lab.to_tracker.alter = [&put_back, poses = 0](std::string& answer) mutable {
    poses += point_of(answer) == "P3" ? 1 : 0;
    if (poses >= 3 && !put_back) shift(answer, point_of(answer).starts_with('B') ? 2 : 0);
  };
  CHECK(after.run().exit_code() == ExitCode::safety_stop);
  put_back = true;
  CHECK(after.run().state == State::done);
}

}  // namespace trammel::session
