#include "app/session/agreement.hpp"

#include "core/error.hpp"
#include "store/job.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;

namespace {

/// A job without a result: its key alone tells it from others.
store::Id job_of(store::Connection& db, const std::string& stage) {
  store::NewJob job;
  job.campaign_id = store::require_campaign(db, "c").id;
  job.stage = stage;
  job.key = store::job_key({.stage = stage, .campaign = {}});
  return store::add_job(db, job);
}

}  // namespace

TEST_CASE("a stored session passes for what it was, and for nothing else", "[session]") {
  const TemporaryFolder folder;
  folder.write("robot.json", read_text(kPaperRobot));
  const std::string stage = "sim:" + (folder.path() / "robot.json").string();
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  Request request = request_for(small_plan());
  request.stage = stage;
  REQUIRE(run_or_resume(db, request, {}).n_stored == 16);
  const Outcome again = run_or_resume(db, request, {});
  CHECK(again.state == State::done);
  CHECK(again.n_stored == 0);

  const auto refused = [&](Request other, const std::string& said) {
    CHECK_THROWS_WITH(run_or_resume(db, other, {}),
                      Contains("session 's' is stored") && Contains(said));
  };
  Request other = request;
  other.plan.points.pop_back();
  refused(other, "16 points, expected small of 15");
  other = request;
  other.plan.points[4].target.x_mm += 1;
  refused(other, "point 5");
  other = request;
  other.plan.points[2].set = ReadingSet::validate;
  refused(other, "validate");
  other = request;
  other.plan.approach_mm = 7;
  refused(other, "5 mm, expected 7 mm");
  other = request;
  other.compensation_job = job_of(db, "lsq");
  refused(other, "no correction, expected lsq");

  std::string robot = read_text(kPaperRobot);
  robot.replace(robot.find("20240973"), 8, "20240974");
  folder.write("robot.json", robot);
  refused(request, "another virtual robot");
  CHECK(by_point(db, "c", "s").size() == 16);
}

}  // namespace trammel::session
