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
                        {"lagging by two", lagging(2), kProxied - 1},
                        {"lagging by a line", from_pose(2, one_line_behind()), 1},
                        {"lagging, but for the last digit", lagging_unlike(), 1},
                        {"without a number", from_pose(2, saying("nan")), 1},
                        {"beyond all numbers", from_pose(2, saying("1e308")), 1},
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

TEST_CASE("a first reading that the second contradicts is excluded, and says why",
          "[session][sockets]") {
  Plan fine = proxied_plan(1);
  for (int k = 1; k < kProxied; ++k) {
    fine.points.push_back(fine.points.front());
    fine.points.back().seq = k + 1;
    fine.points.back().target.x_mm += 0.4 * k;
  }
  SocketCampaign campaign(fine);
  std::atomic<bool> lies = true;  // of a place 2 mm away, then of the pose before
  campaign.lab.to_tracker.alter = [&lies, lag = lagging_unlike(),
                                   n = 0](std::string& answer) mutable {
    if (!lies || !point_of(answer).starts_with('P')) return;
    lag(answer);
    if (++n <= 3) shift(answer, 2);
  };
  const Outcome outcome = campaign.run();
  CAPTURE(outcome.detail);
  CHECK(outcome.state == State::faulted);  // by place or by time, whichever tells first
  CHECK(outcome.n_stored == 1);
  CHECK_THAT(outcome.detail, Contains("excluded: readings 1"));
  REQUIRE(campaign.excluded().size() == 1);
  CHECK_THAT(campaign.excluded().at(1), Contains("by the session: "));
  CHECK(campaign.problems(false).empty());
  lies = false;
  CHECK(campaign.run().state == State::done);
  CHECK(campaign.problems().empty());
  CHECK_THAT(campaign.last_event(), Contains("4 points, 1 of them excluded"));
}

TEST_CASE(
    "what is stored before a step stays where the tracker was knocked, and goes where it crept",
    "[session][sockets]") {
  for (const double creeps_mm : {0.0, 0.3, 1.0}) {
    CAPTURE(creeps_mm);
    SocketCampaign campaign(proxied_plan(8));
    campaign.request.policy.patience_s = 30;
    campaign.lab.to_tracker.alter = creeps_mm > 0 ? creeping(6, creeps_mm) : knocked(7, 3);
    const Outcome outcome = campaign.run();
    CAPTURE(outcome.detail);
    CHECK(outcome.state != State::done);
    CHECK(campaign.excluded().empty() == (creeps_mm == 0));
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
    // The tracker stands where it was knocked to, and is registered there: the points are not.
    CHECK_THAT(outcome.detail, Contains("base nest") && Contains("measured again") &&
                                   Contains("excluded: readings 1, 2, 3"));
    CHECK(few.problems(false).empty());
    CHECK(few.run().state == State::done);
    CHECK_THAT(few.last_event(), Contains("3 of them excluded"));
  }
  SocketCampaign after(proxied_plan(3));  // knocked when all was measured: no point is wrong
  after.lab.to_tracker.alter = [poses = 0](std::string& answer) mutable {
    if (poses >= 3) shift(answer, 2);
    poses += point_of(answer) == "P3" ? 1 : 0;
  };
  const Outcome unharmed = after.run();
  CAPTURE(unharmed.detail);
  CHECK(unharmed.state == State::done);
  CHECK(after.excluded().empty());
}

TEST_CASE("base nests that can't be seen at the end leave it to a resume to settle",
          "[session][sockets]") {
  for (const double by_mm : {0.0, 2.0}) {
    CAPTURE(by_mm);
    SocketCampaign campaign(proxied_plan(3));
    std::atomic<bool> hidden = true;
    campaign.lab.to_tracker.alter = [&hidden, knock = knocked(2, by_mm),
                                     poses = 0](std::string& answer) mutable {
      knock(answer);
      const std::string point = point_of(answer);
      if (hidden && poses >= 3 && point.starts_with('B')) answer = "ERR-306 no such point\r\n";
      poses += point == "P3" ? 1 : 0;
    };
    CHECK(campaign.run().exit_code() == ExitCode::device);
    hidden = false;
    const Outcome again = campaign.run();
    CAPTURE(again.detail);
    CHECK(again.exit_code() == (by_mm > 0 ? ExitCode::safety_stop : ExitCode::ok));
  }
}

}  // namespace trammel::session
