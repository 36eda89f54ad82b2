#include "app/job/diff.hpp"

#include "app/job/run.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::job;
using namespace trammel::tests;

TEST_CASE("JSON differences name the path and both values, and nothing that is equal", "[job]") {
  const Json a = {{"same", {1, 2}}, {"rows", {{{"x", 1}}, {{"x", 2}}}}, {"gone", true}, {"n", {1}}};
  const Json b = {
      {"same", {1, 2}}, {"rows", {{{"x", 1}}, {{"x", 3}}}}, {"n", {1, 2}}, {"new", 0.5}};
  const Json found = json_differences(a, b);
  REQUIRE(found.size() == 4);
  CHECK(found[0] == Json({{"path", "rows[1].x"}, {"a", 2}, {"b", 3}}));
  CHECK(found[1] == Json({{"path", "gone"}, {"a", true}, {"b", nullptr}}));
  CHECK(found[2] == Json({{"path", "n"}, {"a", {1}}, {"b", {1, 2}}}));
  CHECK(found[3] == Json({{"path", "new"}, {"a", nullptr}, {"b", 0.5}}));
  CHECK(json_differences(a, a).empty());
}

TEST_CASE(
    "two jobs of other parameters differ in those, in figures and in points, and in nothing else",
    "[job]") {
  PaperStore paper;
  const store::Job a = run(paper.db, {.campaign = "paper", .stage = "rbf"}).job;
  Request other{.campaign = "paper", .stage = "rbf"};
  other.parameters = {{"seed", 2}};
  const store::Job b = run(paper.db, other).job;
  const Json d = job_differences(paper.db, a, b);
  REQUIRE(d["parameters"].size() == 1);
  CHECK(d["parameters"][0]["path"] == "seed");
  REQUIRE(d["changed"].size() == 1);
  CHECK(d["changed"][0]["part"] == "parameters");
  CHECK(d["same_result"] == false);
  CHECK(d["readings_only_in"]["a"].empty());
  CHECK(d["points"].size() > 100);  // the centres moved
  for (std::size_t k = 1; k < d["points"].size(); ++k) {
    CHECK(d["points"][k]["moved_mm"] <= d["points"][k - 1]["moved_mm"]);
  }
  for (const Json& row : d["statistics"]) {
    CHECK_THAT(row["path"].get<std::string>(), Contains(".after.") || Contains("improvement"));
  }
}

TEST_CASE("a job whose points alone were changed is no longer the same outcome", "[job]") {
  PaperStore paper;
  const store::Job job = run(paper.db, {.campaign = "paper", .stage = "idw"}).job;
  store::NewJob again = compute(paper.db, request_of(paper.db, job));
  CHECK(same_outcome(again, job.data));
  Json result = Json::parse(again.result_json);
  Json& x_mm = result.at("points").at("x_mm").at(3);
  x_mm = std::nextafter(x_mm.get<double>(), 1.0);
  again.result_json = canonical_text(result);
  CHECK_FALSE(same_outcome(again, job.data));
}
