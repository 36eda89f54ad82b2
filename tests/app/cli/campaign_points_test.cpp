// A tracker's file on the command line: looked into, tried, imported, refused.

#include <nlohmann/json.hpp>

#include "core/judge/iso9283.hpp"
#include "store/campaign.hpp"
#include "store/digest.hpp"
#include "store/open.hpp"
#include "store/session.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using Parsed = nlohmann::json;
using tests::Finished;

namespace {

const std::string kTracker = tests::source_folder() + "/examples/tracker-files/";

Finished in(const tests::TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.end(), {"--db", "lab.db"});
  return tests::run_program(words, folder.path());
}

std::vector<std::string> import_of(const std::string& points, const std::string& layout,
                                   const std::vector<std::string>& more = {}) {
  std::vector<std::string> words = {"campaign", "import", "--points", points, "--layout", layout};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

const std::string kSaPoints = kTracker + "spatialanalyzer.txt";
const std::string kSaLayout = kTracker + "spatialanalyzer.layout.json";

}  // namespace

TEST_CASE("a look into a tracker's file names misses and outliers by line", "[points][cli]") {
  const tests::TemporaryFolder folder;
  std::string text;
  for (int k = 0; k < 12; ++k) {
    text += k == 4   ? "S1;0;0;0;;;\n"
            : k == 9 ? "S1;90.0;2.0;3.0;;;\n"
                     : "S1;1.00" + std::to_string(k % 3) + ";2.0;3.0;;;\n";
  }
  folder.write("p.xyz", text);
  const Finished shown = in(folder, {"campaign", "points", "p.xyz"});
  CHECK(shown.exit_code == 0);
  CHECK_THAT(shown.out, Contains("12 rows, delimited, mm (not stated in the file)") &&
                            Contains("line 5: S1: miss (zero)") &&
                            Contains("line 10: S1: gross outlier, 88.999 mm") &&
                            Contains("call it RP_l (n = 10)"));
  const Parsed look = Parsed::parse(in(folder, {"campaign", "points", "p.xyz", "--json"}).out);
  CHECK(tests::schema_errors(look, "campaign-points.schema.json") == "");
  CHECK(look["places"][0]["n"] == 10);
  CHECK(look["places"][0]["outliers"][0]["line"] == 10);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "lab.db"));
}

TEST_CASE("a tracker's file is tried without a trace, imported once, and then there already",
          "[points][cli]") {
  const tests::TemporaryFolder folder;
  const Finished tried = in(folder, import_of(kSaPoints, kSaLayout, {"--dry-run"}));
  INFO(tried.err);
  CHECK(tried.exit_code == 0);
  CHECK_THAT(tried.out, Contains("dry run, would import campaign tracker-sa: 24 readings") &&
                            Contains("line 26: miss (zero)") &&
                            Contains("lines 55, 56, 57: pose 16") &&
                            Contains("one false alarm in 1000 checks"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "lab.db"));
  CHECK(in(folder, import_of(kSaPoints, kSaLayout)).exit_code == 0);
  const Parsed again = Parsed::parse(in(folder, import_of(kSaPoints, kSaLayout, {"--json"})).out);
  CHECK(tests::schema_errors(again, "campaign-import.schema.json") == "");
  CHECK(again["already_stored"] == true);
  CHECK(again["points"]["dropped"].size() == 2);
  CHECK(in(folder, {"calibrate", "lsq", "tracker-sa"}).exit_code == 0);
}

TEST_CASE("the store keeps each reading's lines, and what the import was made of",
          "[points][cli]") {
  const tests::TemporaryFolder folder;
  REQUIRE(in(folder, import_of(kSaPoints, kSaLayout)).exit_code == 0);
  store::Connection db = store::open(folder.path() / "lab.db", store::Access::read_only);
  const auto campaign = store::require_campaign(db, "tracker-sa");
  const store::StoredReading first = store::readings(db, campaign.id).front();
  REQUIRE(first.data.raw_reply);
  CHECK_THAT(*first.data.raw_reply, Contains("Pose01,  P1"));
  const Parsed kept =
      Parsed::parse(store::list_sessions(db, campaign.id).front().settings_json)["points"];
  CHECK(kept["file"] == "spatialanalyzer.txt");
  CHECK(kept["sha256"] == store::hex(store::sha256_of(tests::read_text(kSaPoints))));
  CHECK(kept["layout"]["format"] == "layout/1");
  CHECK(kept["dropped"][0]["lines"] == Parsed::array({26}));
  CHECK(in(folder, {"db", "verify"}).exit_code == 0);
}

TEST_CASE("dates that no line decides ask for --date, and are imported with it", "[points][cli]") {
  const tests::TemporaryFolder folder;
  std::string text = tests::read_text(kSaPoints);
  for (std::size_t at = 0; (at = text.find("02/13/25", at)) != std::string::npos;) {
    text.replace(at, 8, "02/12/25");
  }
  folder.write("points.txt", text);
  Parsed layout = Parsed::parse(tests::read_text(kSaLayout));
  layout["points"].erase("date");
  layout["mechanism"] = kTracker + "../paper/robot.json";
  layout["plan"] = kTracker + "plan.json";
  folder.write("layout.json", layout.dump());
  const Finished open = in(folder, import_of("points.txt", "layout.json"));
  CHECK(open.exit_code == 4);
  CHECK_THAT(open.err, Contains("two ways") && Contains("--date"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "lab.db"));
  const Finished said = in(folder, import_of("points.txt", "layout.json", {"--date", "day-first"}));
  CHECK(said.exit_code == 0);
  CHECK_THAT(said.out, Contains("2025-12-02T09:00:04"));
}

TEST_CASE("a line that does not say what to import, or how, is a usage error", "[points][cli]") {
  const tests::TemporaryFolder folder;
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"campaign", "import"},
           {"campaign", "import", "folder", "--points", kSaPoints, "--layout", kSaLayout},
           {"campaign", "import", "--points", kSaPoints},
           {"campaign", "import", "folder", "--layout", kSaLayout}}) {
    CAPTURE(words);
    const Finished refused = in(folder, words);
    CHECK(refused.exit_code == 2);
    CHECK(refused.out.empty());
  }
  Parsed layout = Parsed::parse(tests::read_text(kSaLayout));
  layout.erase("plan");
  layout["mechanism"] = kTracker + "../paper/robot.json";
  folder.write("layout.json", layout.dump());
  const Finished no_plan = in(folder, import_of(kSaPoints, "layout.json"));
  CHECK(no_plan.exit_code == 2);
  CHECK_THAT(no_plan.err, Contains("--plan"));
}
