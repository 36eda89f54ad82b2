// Which points a plan may ask for, which robot a check was for, and whose database a demo writes.

#include <stdlib.h>

#include <nlohmann/json.hpp>

#include "app/files/plan_json.hpp"
#include "core/mechanism/geometry.hpp"
#include "core/plan/check.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::run_here;

namespace {

const std::string kRobot = tests::source_folder() + "/examples/paper/robot.json";

Plan planned(const tests::TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.begin(), {"plan", "create"});
  words.insert(words.end(), {"--out", "made.json", "--overwrite"});
  const auto made = run_here(words, folder.path());
  INFO(made.err);
  REQUIRE(made.exit_code == 0);
  return read_plan(folder.path() / "made.json");
}

}  // namespace

TEST_CASE("--within holds for every grid of poses, and a lattice fills it", "[cli]") {
  const tests::TemporaryFolder folder;
  for (const char* grid : {"paper-80", "paper-48", "lattice", "circle", "circles", "optimal"}) {
    CAPTURE(grid);
    const Plan plan = planned(folder, {grid, "--within", "-60", "45"});
    double highest_mm = -1000;
    for (const PlannedPoint& p : plan.points) {
      for (const double at_mm : {p.target.x_mm, p.target.y_mm}) {
        CHECK(at_mm >= -60);
        CHECK(at_mm <= 45 + 1e-6);
        highest_mm = std::max(highest_mm, at_mm);
      }
    }
    CHECK(highest_mm > 20);
  }
  CHECK(planned(folder, {"lattice", "--within", "-150", "150", "--step", "50"}).points.size() ==
        49);
  CHECK(run_here({"plan", "create", "lattice", "--within", "60", "-60"}, folder.path()).exit_code ==
        2);
  CHECK(run_here({"plan", "create", "circle", "--within", "1", "2"}, folder.path()).exit_code == 4);
}

TEST_CASE("with a mechanism or a campaign only what is safe, or was measured, is planned",
          "[cli]") {
  const tests::TemporaryFolder folder;
  const std::vector<std::string> wide = {"lattice", "--half-width", "250", "--step", "50"};
  const auto safe = [&](std::vector<std::string> more) {
    more.insert(more.begin(), wide.begin(), wide.end());
    return planned(folder, more);
  };
  const Plan all = safe({});
  CHECK_FALSE(check(all, paper_mechanism()).empty());
  const Plan reached = safe({"--mechanism", kRobot});
  CHECK(reached.points.size() > 9);
  CHECK(reached.points.size() < all.points.size());
  for (const PlannedPoint& p : reached.points) {
    Plan one{"", 5, {p}};
    one.points[0].seq = 1;
    CHECK(check(one, paper_mechanism()).empty());
  }
  REQUIRE(run_here({"campaign", "import", tests::kDriveError, "--db", "a.db"}, folder.path())
              .exit_code == 0);
  const Plan measured =
      planned(folder, {"lattice", "--step", "10", "--campaign", "drive-error", "--db", "a.db"});
  double farthest_mm = 0;
  for (const PlannedPoint& p : measured.points) {
    farthest_mm = std::max({farthest_mm, std::abs(p.target.x_mm), std::abs(p.target.y_mm)});
  }
  CHECK(farthest_mm == 100);  // where its readings end
}

TEST_CASE("the help of a grid shows what shapes it, and what does not is refused", "[cli]") {
  const auto lattice = run_here({"plan", "create", "lattice", "--help"});
  CHECK_THAT(lattice.out, Contains("--half-width") && Contains("--step"));
  for (const char* other : {"--radius", "--travel", "--criterion", "--job"}) {
    CHECK_THAT(lattice.out, !Contains(other));
  }
  CHECK_THAT(run_here({"plan", "create", "rail", "--help"}).out,
             Contains("--travel") && !Contains("--half-width"));
  CHECK_THAT(run_here({"plan", "create", "--help"}).out,
             Contains("--travel") && Contains("--half-width") && Contains("--radius"));
  CHECK(run_here({"plan", "create", "lattice", "--job", "1"}).exit_code == 2);
}

TEST_CASE("a check without a mechanism names the robot it assumed, and what to do about it",
          "[cli]") {
  const auto assumed = run_here({"plan", "check", "paper-48"});
  CHECK(assumed.exit_code == 0);
  CHECK_THAT(assumed.out, Contains("on the paper's 3-PRR, which was assumed"));
  CHECK_THAT(assumed.err, Contains("next: trammel plan check paper-48 --mechanism FILE"));
  const auto named = run_here({"plan", "check", "paper-48", "--mechanism", kRobot});
  CHECK_THAT(named.out, Contains("is safe") && !Contains("assumed"));
  CHECK_THAT(named.err, !Contains("--mechanism FILE"));
}

TEST_CASE("the demo writes a database of its own, whatever TRAMMEL_DB says", "[cli]") {
  const tests::TemporaryFolder folder;
  const auto laboratory = folder.write("laboratory.db", "somebody's");
  REQUIRE(::setenv("TRAMMEL_DB", laboratory.c_str(), 1) == 0);
  const auto planned_demo = run_here({"demo", "here", "--dry-run", "--json"}, folder.path());
  ::unsetenv("TRAMMEL_DB");
  REQUIRE(planned_demo.exit_code == 0);
  CHECK(nlohmann::json::parse(planned_demo.out)["database"] == "here/trammel.db");
  folder.write("trammel.db", "somebody's");
  const auto beside = run_here({"demo", ".", "--dry-run"}, folder.path());
  CHECK(beside.exit_code == 4);
  CHECK_THAT(beside.err, Contains("no demo began"));
}
