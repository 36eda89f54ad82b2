// The whole campaign: twice the same bits, and the same numbers whatever kills it on the way.

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "core/statistics/random.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"
#include "store/session.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_program;

namespace {

using Json = nlohmann::json;

/// How often each planned point of each session is stored; reference visits apart.
std::map<std::pair<std::string, int>, int> stored_points(const std::filesystem::path& db) {
  store::Connection connection = store::open(db, store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, "paper");
  std::map<std::pair<std::string, int>, int> count;
  for (const store::SessionRow& session : store::list_sessions(connection, campaign.id)) {
    if (session.name.find(", reference") != std::string::npos) continue;
    for (const store::Point& point : store::points(connection, session.id)) {
      count[{session.name, point.seq}] = 0;
    }
    std::map<store::Id, int> seq_of_attempt;
    for (const auto& a : store::attempts(connection, session.id))
      seq_of_attempt[a.id] = a.point_seq;
    for (const auto& reading : store::readings(connection, campaign.id, {session.id})) {
      ++count[{session.name, seq_of_attempt.at(reading.attempt_id.value())}];
    }
  }
  return count;
}

/// Points that the diagnoses suggested and the runner measured.
std::size_t suggested(const Json& report) {
  std::size_t n = 0;
  for (const Json& round : report.at("story")) n += round.at("n_next_points").get<std::size_t>();
  return n;
}

void check_each_point_once(const std::filesystem::path& db, const Json& report) {
  const auto count = stored_points(db);
  CHECK(count.size() == 80 * 3 + 48 * 4 + 288 * 2 + suggested(report));
  for (const auto& [point, n] : count) {
    CAPTURE(point.first, point.second);
    CHECK(n == 1);
  }
}

/// The story of the diagnosis, less what counts epochs and readings: a resume adds some.
Json told(const Json& report) {
  Json story = report.at("story");
  for (Json& round : story) round.erase("job_key");
  return story;
}

/// >= 90 % and <= 1.3 x the noise floor, measured again; below what the two maps leave.
void check_model(const Json& report) {
  const double floor_mm = report.at("floor_mean_mm");
  std::map<std::string, Json> tables;
  for (const Json& table : report.at("tables")) tables[table.at("id")] = table;
  for (const char* id : {"model-80-position", "model-48-position"}) {
    CAPTURE(id);
    REQUIRE(tables.contains(id));
    const Json& table = tables[id];
    CHECK(table.at("after_is") == "measured");
    CHECK(table.at("improvement_pct") >= 90.0);
    CHECK(table.at("after").at("mean") <= 1.3 * floor_mm);
    CHECK(table.at("demand").at("reached") == true);
  }
  CHECK(tables.at("model-80-position").at("in_sample") == true);
  const Json& unseen = tables.at("model-48-position");
  CHECK(unseen.at("in_sample") == false);
  for (const char* map : {"idw-48-position", "rbf-48-position"}) {
    CHECK(unseen.at("before") == tables.at(map).at("before"));
    CHECK(unseen.at("after").at("mean") < tables.at(map).at("after").at("mean"));
  }
  CHECK(tables.contains("model-80-attitude"));
  CHECK(tables.contains("model-48-attitude"));
}

void check_story(const Json& story) {
  REQUIRE(story.size() >= 1);
  REQUIRE(story.size() <= 4);
  CHECK(story.back().at("verdict") == "explained");
  std::vector<std::string> names;
  for (const Json& effect : story.back().at("effects")) names.push_back(effect.at("name"));
  for (const char* hidden : {"lead_scale", "backlash"}) {
    CHECK(std::count(names.begin(), names.end(), hidden) == 1);
  }
  const Json& gap = story.back().at("gap");
  CHECK(gap.front().at("model") == "nominal");
  CHECK(gap.back().at("validate_rms_mm") < 0.1 * gap.front().at("validate_rms_mm").get<double>());
  for (const Json& round : story) CHECK(round.at("judged_on")[0].at("session") == "measure-48");
}

/// Every piece of the report that the README shows is what the program prints.
void check_readme(const std::string& report) {
  std::istringstream readme(tests::read_text(tests::source_folder() + "/README.md"));
  int n_pieces = 0;
  std::optional<std::string> piece;
  for (std::string line; std::getline(readme, line);) {
    if (line != "```") {
      if (piece) *piece += line + "\n";
      continue;
    }
    const bool command = piece && piece->starts_with("$ ");
    if (piece && !command) {
      ++n_pieces;
      CHECK_THAT(report, Contains(*piece));
    }
    piece = piece ? std::nullopt : std::optional<std::string>("");
  }
  CHECK(n_pieces == 7);
}

/// The demo, undisturbed; run once for all cases.
struct Undisturbed {
  tests::TemporaryFolder folder;
  Finished first = run_program({"demo", "whole"}, folder.path());
  std::filesystem::path whole = folder.path() / "whole";
  std::string report = tests::read_text(whole / "report.json");
};

const Undisturbed& undisturbed() {
  static const Undisturbed made;
  REQUIRE(made.first.exit_code == 0);
  return made;
}

}  // namespace

TEST_CASE("the demo run twice gives bit-identical results", "[protocol]") {
  const auto& [folder, first, whole, report] = undisturbed();
  const tests::TemporaryFolder other;
  REQUIRE(run_program({"demo", "b"}, other.path()).exit_code == 0);
  CHECK(report == tests::read_text(other.path() / "b/report.json"));
  CHECK(first.out == tests::read_text(whole / "report.txt"));
  check_each_point_once(whole / "trammel.db", Json::parse(report));

  // Run again, everything is skipped and nothing changes.
  const Finished again = run_program({"demo", "whole"}, folder.path());
  CHECK(again.exit_code == 0);
  CHECK(tests::read_text(whole / "report.json") == report);
  std::size_t n_skipped = 0;
  for (const char* not_measured : {"(done before)", "skipped: "}) {
    for (auto at = again.err.find(not_measured); at != std::string::npos;
         at = again.err.find(not_measured, at + 1)) {
      ++n_skipped;
    }
  }
  CHECK(n_skipped == 19);

  const Json json = Json::parse(report);
  REQUIRE(json.at("tables").back().at("id") == "circles");
  CHECK(json.at("tables").back().at("circles").size() == 4);
  const Json& circles = json.at("tables").back();
  CHECK(circles.at("circles")[0].at("n") == 72);
  // The four circles meet the star that was fitted in twelve points.
  CHECK(circles.at("before").at("n") == 276);
  REQUIRE(circles.at("others").size() == 1);
  CHECK(circles.at("others")[0].at("judged") == "in-sample");
  CHECK(circles.at("others")[0].at("before").at("n") == 12);
  check_model(json);
  check_story(json.at("story"));
  check_readme(first.out);
  CHECK_THAT(first.out, Contains("round 1: ") && Contains("x a perfect reading: reached"));
  // What gets worse is said in words, with the reason.
  REQUIRE(json.at("remarks").size() == 1);
  CHECK_THAT(json.at("remarks")[0].get<std::string>(), Contains("lsq makes attitude worse") &&
                                                           Contains("0.0550 deg") &&
                                                           Contains("--attitude-weight"));
  CHECK_THAT(first.out, Contains("Note: lsq makes attitude worse"));
  CHECK(first.out.find("-0.0000") == std::string::npos);
  for (const Json& table : json.at("tables")) {
    // Least squares on 18 constants leaves 0.05 to 0.1 mm of a drive error, and must not add to it.
    if (table.at("figure") == "position") CHECK(table.at("improvement_pct") > 40);
    if (table.at("method") == "lsq" && table.at("before").at("n") == 48) continue;
    CHECK(table.at("after_is") == "measured");
  }
}

TEST_CASE(
    "killed at random times and resumed, every point is stored once and the numbers are the same",
    "[protocol]") {
  const tests::TemporaryFolder folder;
  Random random(11);
  int n_kills = 0;
  Finished last{.exit_code = -1, .out = {}, .err = {}};
  while (last.exit_code != 0 && n_kills < 60) {
    const int after_ms = static_cast<int>(random.uniform(20, 300));
    last = run_program({"demo", "killed"}, folder.path(),
                       n_kills < 12 ? std::optional<int>(after_ms) : std::nullopt);
    if (last.exit_code != 0) ++n_kills;
    CAPTURE(last.err);
    REQUIRE((last.exit_code == 0 || last.exit_code == -1));
  }
  REQUIRE(last.exit_code == 0);
  CHECK(n_kills >= 1);
  const Json whole = Json::parse(undisturbed().report);
  check_each_point_once(folder.path() / "killed/trammel.db", whole);
  const Json killed = Json::parse(tests::read_text(folder.path() / "killed/report.json"));
  for (const char* part : {"tables", "contest", "network", "floor_mean_mm"}) {
    CAPTURE(part, n_kills);
    CHECK(whole.at(part) == killed.at(part));
  }
  CHECK(told(whole) == told(killed));
  CHECK(whole.at("identification").at("parameters") ==
        killed.at("identification").at("parameters"));
}
