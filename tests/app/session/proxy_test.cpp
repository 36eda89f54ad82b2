// A proxy between the program and its devices that renames, holds back, freezes, doubles, shifts:
// what it makes of a reading is not stored.

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <regex>

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

using Alter = std::function<void(std::string&)>;

/// "P2" of the answer of a measurement; empty for one that failed.
std::string point_of(const std::string& answer) {
  std::smatch found;
  const bool is = std::regex_search(answer, found, std::regex("Measurement (\\w+) result"));
  return is ? found[1].str() : "";
}

/// From the n-th answer for P1 on (1: the first), `change` what is said of the platform.
Alter from_pose(int n, Alter change) {
  return [n, change = std::move(change), poses = 0](std::string& answer) mutable {
    const std::string point = point_of(answer);
    poses += point == "P1" ? 1 : 0;
    if (point.starts_with('P') && poses >= n) change(answer);
  };
}

Alter renaming() {
  return [](std::string& answer) {
    const std::size_t at = answer.find("P1 result");
    if (at != std::string::npos) answer[at + 1] = '2';
  };
}

/// Each answer is the one before of the same point.
Alter lagging() {
  return [last = std::map<std::string, std::string>()](std::string& answer) mutable {
    const std::string point = point_of(answer);
    const auto before = last.find(point);
    if (before == last.end()) {
      last[point] = answer;
    } else {
      std::swap(before->second, answer);
    }
  };
}

Alter frozen() {
  return [first = std::map<std::string, std::string>()](std::string& answer) mutable {
    answer = first.emplace(point_of(answer), answer).first->second;
  };
}

Alter dated(const char* date) {
  return [date](std::string& answer) {
    answer = std::regex_replace(answer, std::regex("\\d\\d/\\d\\d/\\d{4}"), date);
  };
}

/// All that the instrument sees stands elsewhere, along its x.
void shift(std::string& answer, double by_mm) {
  std::smatch found;
  if (!std::regex_search(answer, found, std::regex("result (-?[0-9.]+)"))) return;
  answer.replace(static_cast<std::size_t>(found.position(1)),
                 static_cast<std::size_t>(found.length(1)),
                 fmt::format("{:.6f}", std::stod(found[1].str()) + by_mm));
}

/// The answers before, and not to the last bit.
Alter lagging_unlike() {
  return [lag = lagging()](std::string& answer) {
    lag(answer);
    shift(answer, 1e-6);
  };
}

/// The tracker is knocked before its n-th pose: base nests, too, are seen elsewhere.
Alter knocked(int n, double by_mm) {
  return [n, by_mm, poses = 0](std::string& answer) mutable {
    poses += point_of(answer) == "P1" ? 1 : 0;
    if (poses >= n) shift(answer, by_mm);
  };
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
    CHECK(few.run().state == State::done);  // taken as it is, by an operator who has read that
  }
}

}  // namespace trammel::session
