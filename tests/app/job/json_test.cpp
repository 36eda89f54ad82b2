#include "app/job/json.hpp"

#include "app/job/stages.hpp"
#include "store/job_key.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("the canonical text of a document is that of the store", "[job]") {
  const job::Json odd = job::Json::parse(
      R"({"b":[],"a":{"z":{},"\u00e9":1,"Z":[[],{"y":null,"x":true}]},"":"\"\\\n\u0001","ab":-0.0,)"
      R"("n":[1e-320,0.1,1e300,12345678901234567890,-7,1.0]})");
  CHECK(job::canonical_text(odd) == store::canonical_json(odd.dump(), "odd"));
  CHECK(job::canonical_text(7) == "7");
  for (const char* name : {"lsq", "geometry", "idw"}) {
    const job::Stage& stage = job::find_stage(name);
    const auto details =
        stage.run(tests::paper_campaign(), stage.complete(job::Json::object())).details;
    CHECK(job::canonical_text(details) == store::canonical_json(details.dump(), "details"));
  }
}
