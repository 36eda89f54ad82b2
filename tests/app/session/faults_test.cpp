// Every fault at every point of a short campaign: what is stored, what is tried again, what ends
// it.

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "store/verify.hpp"
#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;
using device::Status;

namespace {

constexpr int kShort = 4;  // points
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Plan short_plan() {
  Plan plan = small_plan();
  plan.points.resize(kShort);
  return plan;
}

/// A database, faults that know which point is being measured, and a control without any.
struct Campaign_under_fault {
  TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  std::shared_ptr<Faults> faults = std::make_shared<Faults>();
  Surroundings around;
  int point = 1;  // that is being measured

  Campaign_under_fault() {
    around.open = opening(faults);
    around.stored = [this](int n) { point = n + 1; };
  }
  Outcome walk() { return run(db, request(), around); }
  static Request request() {
    Request request = request_for(short_plan());
    request.policy.beam_patience_s = 3;
    return request;
  }
  /// Once, the first time it is asked at `at`.
  Faults::Ask once(int at, Status status) {
    return [this, at, status, left = 1](int) mutable {
      if (point != at || left == 0) return Status::ok;
      --left;
      return status;
    };
  }
  std::vector<store::Attempt> attempts() {
    const auto campaign = store::require_campaign(db, "c");
    return store::attempts(db, store::find_session(db, campaign.id, "s")->id);
  }
  int count(int seq, const std::string& status) {
    int n = 0;
    for (const auto& a : attempts()) n += a.point_seq == seq && a.status == status ? 1 : 0;
    return n;
  }
};

const std::map<int, Reading>& undisturbed() {
  static const std::map<int, Reading> readings = [] {
    Campaign_under_fault calm;
    REQUIRE(calm.walk().state == State::done);
    CHECK(calm.faults->stops == 0);
    for (const auto& a : calm.attempts()) CHECK(a.status == "ok");
    return by_point(calm.db, "c", "s");
  }();
  return readings;
}

void check_undisturbed(store::Connection& db) {
  const auto readings = by_point(db, "c", "s");
  REQUIRE(readings.size() == kShort);
  for (const auto& [seq, reading] : readings) CHECK(same_bits(reading, undisturbed().at(seq)));
  CHECK(store::verify(db).ok());
}

/// A fault, by what it does to the devices of one campaign at one point.
struct Fault {
  const char* name;
  std::function<void(Campaign_under_fault&, int at)> arm;
  ExitCode code = ExitCode::ok;  // ok: tried again, and it succeeds
  const char* said = "";
};

/// What a device answers once, at a point, in place of its number.
template <class Report>
auto once_at(Campaign_under_fault& c, int at, std::function<void(Report&)> change) {
  return [&c, at, change, left = 1](Report& report, int) mutable {
    if (c.point != at || left == 0) return;
    --left;
    change(report);
  };
}

std::vector<Fault> all_faults() {
  using C = Campaign_under_fault;
  const auto measuring = [](Status s) {
    return [s](C& c, int at) { c.faults->measure = c.once(at, s); };
  };
  const auto moving = [](Status s) {
    return [s](C& c, int at) { c.faults->move = c.once(at, s); };
  };
  const auto asking = [](Status s) {
    return [s](C& c, int at) { c.faults->beam = c.once(at, s); };
  };
  const auto pose = [](double x) {
    return [x](C& c, int at) {
      c.faults->pose = once_at<device::PoseReport>(c, at, [x](auto& r) { r.pose.x_mm = x; });
    };
  };
  return {
      {"beam lost while moving", asking(Status::beam_broken)},
      {"beam stale while moving", asking(Status::timeout)},
      {"beam lost while measuring", measuring(Status::beam_broken)},
      {"no answer of the tracker", measuring(Status::timeout)},
      {"unstable readings", measuring(Status::unstable)},
      {"the stage is not in position in time", moving(Status::timeout)},
      {"no answer of the thermometer",
       [](C& c, int at) { c.faults->thermometer = c.once(at, Status::timeout); }},
      {"limit", moving(Status::limit), ExitCode::device, "limit"},
      {"following error", moving(Status::following_error), ExitCode::device, "following error"},
      {"amplifier fault", moving(Status::fault), ExitCode::device, "fault"},
      {"tracker fault", measuring(Status::fault), ExitCode::device, "fault"},
      {"a pose that is no number", pose(kNaN), ExitCode::device, "no pose"},
      {"a pose out of this world", pose(1e300), ExitCode::device, "no pose"},
      {"a pose beyond the gate", pose(500), ExitCode::safety_stop, "gate"},
      {"a rail beyond the gate",
       [](C& c, int at) {
         c.faults->encoder =
             once_at<device::StageReport>(c, at, [](auto& r) { r.encoder_mm[1] += 30; });
       },
       ExitCode::safety_stop, "gate"},
      {"an encoder that gives no number",
       [](C& c, int at) {
         c.faults->encoder =
             once_at<device::StageReport>(c, at, [](auto& r) { r.encoder_mm[1] = kNaN; });
       },
       ExitCode::safety_stop, "no numbers"},
      {"a temperature that is no number",
       [](C& c, int at) {
         c.faults->temperature =
             once_at<device::TemperatureReport>(c, at, [](auto& r) { r.temp_degc = kNaN; });
       },
       ExitCode::device, "no temperature"},
  };
}

}  // namespace

TEST_CASE(
    "every fault at every point is tried again or ends the session, and a resume gives the "
    "undisturbed bits",
    "[session]") {
  for (const Fault& fault : all_faults()) {
    for (int at = 1; at <= kShort; ++at) {
      CAPTURE(fault.name, at);
      Campaign_under_fault campaign;
      fault.arm(campaign, at);
      const Outcome outcome = campaign.walk();
      CHECK(outcome.exit_code() == fault.code);
      CHECK(campaign.faults->stops == 1);  // motion first
      CHECK(campaign.faults->calls_before_stop == 0);
      CHECK(campaign.count(at, "failed") == 1);
      if (fault.code == ExitCode::ok) {
        CHECK(outcome.state == State::done);
        CHECK(campaign.count(at, "ok") == 1);
      } else {
        CHECK(outcome.state == State::faulted);
        CHECK(outcome.n_stored == at - 1);
        CHECK(campaign.count(at, "ok") == 0);
        CHECK_THAT(outcome.detail, Contains(fault.said));
        CHECK(by_point(campaign.db, "c", "s").size() == static_cast<std::size_t>(at - 1));
        CHECK(resume(campaign.db, "c", "s", {}).state == State::done);
      }
      check_undisturbed(campaign.db);
    }
  }
}

TEST_CASE(
    "the beam lost at any sample of a campaign stops the stage there, and nothing invalid is "
    "stored",
    "[session]") {
  int samples = 0;
  {
    Campaign_under_fault calm;
    REQUIRE(calm.walk().state == State::done);
    samples = calm.faults->beams;
  }
  CHECK(samples > 6 * kShort);
  int stopped_on_the_way = 0;
  for (int at = 1; at <= samples; ++at) {
    CAPTURE(at);
    Campaign_under_fault campaign;
    int asked_after = 0;  // between the break and the stop
    campaign.faults->beam = [&, stops_then = -1](int call) mutable {
      if (call == at) {
        stops_then = campaign.faults->stops;
        return Status::beam_broken;
      }
      asked_after += stops_then == campaign.faults->stops ? 1 : 0;
      return Status::ok;
    };
    CHECK(campaign.walk().state == State::done);
    CHECK(asked_after == 0);  // not one more sample
    CHECK(campaign.faults->calls_before_stop == 0);
    CHECK(campaign.faults->stops == 1);
    int failed = 0;
    for (const auto& a : campaign.attempts()) {
      if (a.status != "failed") continue;
      ++failed;
      stopped_on_the_way += a.detail.find("stopped on the way") != std::string::npos ? 1 : 0;
      CHECK(a.n_readings == 0);
    }
    CHECK(failed == 1);
    check_undisturbed(campaign.db);
  }
  CHECK(stopped_on_the_way > samples / 2);  // the control: they do hit moves
}

TEST_CASE("a beam that stays lost ends the session with what was stored before, whenever it goes",
          "[session]") {
  for (int at = 1; at <= kShort; ++at) {
    Campaign_under_fault campaign;
    campaign.faults->beam = [&](int) {
      return campaign.point >= at ? Status::beam_broken : Status::ok;
    };
    const Outcome outcome = campaign.walk();
    CHECK(outcome.exit_code() == ExitCode::device);
    CHECK(outcome.n_stored == at - 1);
    CHECK(campaign.count(at, "failed") == tries_for(Status::beam_broken));
    CHECK(by_point(campaign.db, "c", "s").size() == static_cast<std::size_t>(at - 1));
  }
}

TEST_CASE("each class of failure has its own bound, and they do not add up", "[session]") {
  const Faults::Ask mixed = [](int call) {
    constexpr std::array<Status, 8> kScript = {
        Status::beam_broken, Status::unstable, Status::timeout,     Status::unstable,
        Status::timeout,     Status::unstable, Status::beam_broken, Status::unstable};
    return call <= 8 ? kScript[static_cast<std::size_t>(call - 1)] : Status::ok;
  };
  Campaign_under_fault campaign;
  campaign.faults->measure = mixed;
  CHECK(campaign.walk().state == State::done);
  CHECK(campaign.count(1, "failed") == 8);
  for (const RetryRule& rule : retry_rules()) {
    Campaign_under_fault always;
    always.faults->measure = [&rule](int) { return rule.status; };
    CHECK(always.walk().state == State::faulted);
    CHECK(always.count(1, "failed") == rule.tries);
    CHECK((rule.tries > 1) == device::may_retry(rule.status));
  }
}

TEST_CASE("a stage that can't be homed, or does not answer to stop, ends the session",
          "[session]") {
  Campaign_under_fault homeless;
  homeless.faults->home = [](int) { return Status::limit; };
  CHECK(homeless.walk().exit_code() == ExitCode::device);
  CHECK(homeless.faults->moves == 0);
  CHECK(homeless.faults->stops == 1);

  Campaign_under_fault deaf;
  deaf.faults->measure = deaf.once(2, Status::beam_broken);
  deaf.faults->stop = [](int) { return Status::timeout; };
  const Outcome outcome = deaf.walk();
  CHECK(outcome.state == State::faulted);  // a lost beam alone would be tried again
  CHECK_THAT(outcome.detail, Contains("beam broken") && Contains("stop"));
}

TEST_CASE("an exception out of a driver stops the stage before anything else", "[session]") {
  Campaign_under_fault campaign;
  campaign.faults->measure = [&](int) -> Status {
    if (campaign.point == 3) throw DeviceError({.what = "the link is gone"});
    return Status::ok;
  };
  CHECK_THROWS_WITH(campaign.walk(), Contains("the link is gone"));
  CHECK(campaign.faults->stops == 1);
  const auto session =
      store::find_session(campaign.db, store::require_campaign(campaign.db, "c").id, "s");
  CHECK(session->last_event == "faulted");
  CHECK(resume(campaign.db, "c", "s", {}).state == State::done);
  check_undisturbed(campaign.db);
}

TEST_CASE("every try leaves its way through the states, and every session its own", "[session]") {
  Campaign_under_fault campaign;
  campaign.faults->measure = campaign.once(2, Status::unstable);
  REQUIRE(campaign.walk().state == State::done);
  const auto id =
      store::find_session(campaign.db, store::require_campaign(campaign.db, "c").id, "s")->id;
  std::vector<std::string> kinds, walks;
  for (const store::Event& e : store::events(campaign.db, id)) {
    (e.kind == "walk" ? walks : kinds).push_back(e.kind == "walk" ? e.detail : e.kind);
  }
  CHECK(kinds == std::vector<std::string>{"checked", "started", "done"});
  REQUIRE(walks.size() == kShort + 1);
  const auto ways = [](const std::string& walk) {
    std::vector<std::string> states;
    for (std::size_t at = walk.find(": ") + 2; at < walk.size();) {
      const std::size_t end = std::min(walk.find(" > ", at), walk.size());
      states.push_back(
          walk.substr(at, walk.find(' ', at) < end ? walk.find(' ', at) - at : end - at));
      at = end + 3;
    }
    return states;
  };
  CHECK_THAT(walks[1], Catch::StartsWith("point 2, try 1: stored > moving 0.000 s > settling"));
  CHECK(ways(walks[1]) ==
        std::vector<std::string>{"stored", "moving", "settling", "measuring", "homed"});
  CHECK(ways(walks[2]) ==
        std::vector<std::string>{"homed", "moving", "settling", "measuring", "stored"});
  for (const std::string& walk : walks) {  // each step is one of the table's
    const auto names = ways(walk);
    for (std::size_t k = 1; k < names.size(); ++k) {
      bool known = false;
      for (const Transition& t : transitions()) {
        known = known || (name_of(t.from) == names[k - 1] && name_of(t.to) == names[k]);
      }
      CHECK(known);
    }
  }
}

}  // namespace trammel::session
