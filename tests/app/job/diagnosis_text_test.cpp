// A diagnosis as a person reads it, and as a program does, on campaigns in which something is
// hidden. Seeds are fixed; the verdicts are held by core/diagnose's own tests.

#include "app/job/diagnosis_text.hpp"

#include <map>
#include <sstream>
#include <utility>

#include "app/job/stages.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"

using namespace trammel;
using namespace trammel::job;
using namespace trammel::tests;

namespace {

Json diagnosed(const Campaign& campaign) {
  const Stage& stage = find_stage("diagnose");
  Json details = stage.run(campaign, stage.complete({{"replicates", 500}})).details;
  details.erase("models");
  Json answer = {{"schema", "trammel/diagnose/1"}, {"kind", kind_text(campaign.simulated)}};
  answer.update(details);
  CHECK(schema_errors(nlohmann::json::parse(answer.dump()), "diagnose.schema.json") == "");
  return details;
}

/// The text with its line breaks and indents as single blanks.
std::string unbroken(const std::string& text) {
  std::istringstream words(text);
  std::string all;
  for (std::string word; words >> word;) all += (all.empty() ? "" : " ") + word;
  return all;
}

/// Every word stands in the text, each after the one before.
void check_in_order(const std::string& broken, const std::vector<std::string>& words) {
  const std::string text = unbroken(broken);
  std::size_t at = 0;
  for (const std::string& word : words) {
    INFO(word << " in\n" << text);
    at = text.find(word, at);
    REQUIRE(at != std::string::npos);
  }
}

HiddenCase hide(const std::string& name, double rho, std::uint64_t seed) {
  return make_case({}, {&family(name)}, rho, seed);
}

/// Every reading twice in a row, the second with a noise of `sigma` standard deviations more.
Campaign measured_twice(const Campaign& campaign, double sigma_mm) {
  Campaign twice = campaign;
  twice.readings.clear();
  int n = 0;
  for (const Reading& r : campaign.readings) {
    for (const double more : {0.0, (n / 2) % 2 == 0 ? sigma_mm : -sigma_mm}) {
      twice.readings.push_back(r);
      twice.readings.back().seq = ++n;
      twice.readings.back().measured->x_mm += more;
      twice.readings.back().measured->phi_rad += more / 100;
    }
  }
  return twice;
}

}  // namespace

TEST_CASE("the text is an argument from what was expected to what can't be seen", "[job]") {
  const Json d = diagnosed(hide("backlash", 28, 3).campaign);
  REQUIRE(d["verdict"] == "explained");
  const std::string text = diagnosis_text(d);
  check_in_order(text, {"explained: what the model is missing is backlash",
                        "expected",
                        "0.0100 mm",
                        "seen",
                        "where: rail",
                        "could be",
                        "backlash (p",
                        "named",
                        "backlash: the stage",
                        "w_",
                        "(1 sigma)",
                        "left",
                        "rivals none",
                        "lost",
                        "worse by",
                        "gap",
                        "nominal",
                        "geometry",
                        "+backlash",
                        "sigma per coordinate",
                        "design",
                        "lead_scale"});
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    const std::string line = text.substr(begin, end - begin);
    INFO(line);
    CHECK(line.size() <= 118);
    begin = end + 1;
  }
  // why not its rivals: what lost, and by how much
  REQUIRE_FALSE(d["considered"].empty());
  for (const Json& c : d["considered"]) {
    CHECK((c["behind_chi2"] > 6.0 || c["usual"] == false));
    CHECK(c["names"] != Json({"backlash"}));
  }
}

TEST_CASE("the headline follows from the verdict, whatever was named beside it", "[job]") {
  Json d = diagnosed(hide("backlash", 28, 3).campaign);
  const Json backlash = d["effects"];
  const Json outliers = {{{"name", "outlier_readings"},
                          {"rails", Json::array()},
                          {"share_of_gap", 0},
                          {"p", 0.0005},
                          {"parameters", Json::array()},
                          {"seq", {12, 77}}}};
  const std::map<std::string, std::string> said = {
      {"nothing_missing", "nothing is missing"},
      {"explained", "all that is wrong|the model is missing is"},
      {"ambiguous", "so does another set"},
      {"unexplained", "no effect of the catalogue explains"}};
  for (const auto& [verdict, words] : said) {
    for (const Json& effects : {Json::array(), outliers, backlash}) {
      if (verdict == "explained" && effects.empty()) continue;
      d["verdict"] = verdict;
      d["effects"] = effects;
      const std::string text = unbroken(diagnosis_text(d));
      const std::string headline = text.substr(0, text.find(" expected "));
      CAPTURE(verdict, headline);
      CHECK_THAT(headline, Catch::Matchers::StartsWith(verdict + ": ") &&
                               Catch::Matchers::Matches(".*(" + words + ").*"));
      CHECK((headline.find("single wrong readings") != std::string::npos) ==
            (verdict == "explained" && effects == outliers));
    }
  }
}

TEST_CASE("a gross mistake is told before any effect, and nothing is fitted", "[job]") {
  Campaign swapped = hide("backlash", 28, 3).campaign;
  for (Reading& r : swapped.readings) std::swap(r.conditions.cmd_mm[0], r.conditions.cmd_mm[1]);
  const Json d = diagnosed(swapped);
  CHECK(d["verdict"] == "unexplained");
  REQUIRE_FALSE(d["suspect"].empty());
  CHECK(d["suspect"].size() <= 2);
  CHECK(d["effects"].empty());
  check_in_order(diagnosis_text(d), {"unexplained: before any effect", "suspect", "swapped",
                                     "as they are", "nothing was fitted"});
}

TEST_CASE("what no point decides is told with the measurement that would", "[job]") {
  const Json d = diagnosed(hide("tracker_scale", 9, 17).campaign);
  REQUIRE(d["verdict"] == "ambiguous");
  REQUIRE_FALSE(d["undecided"].empty());
  check_in_order(diagnosis_text(d), {"ambiguous:", "rivals", "undecided", "scale bar"});
}

TEST_CASE("an unexplained gap tells where it lives and what was tried, and adds nothing", "[job]") {
  const Json d = diagnosed(hide("half_turn", 28, 13).campaign);
  REQUIRE(d["verdict"] == "unexplained");
  CHECK(d["effects"].empty());
  CHECK(d["gap"].size() == 2);
  check_in_order(diagnosis_text(d),
                 {"unexplained:", "lives", "repeating every 5.00 mm", "calibrate hybrid"});
  // and the points that show it again
  REQUIRE_FALSE(d["next_points"].empty());
  CHECK_THAT(d["next_points"][0]["why"].get<std::string>(), Contains("shows again rail"));
}

TEST_CASE("without a stated sigma the repeats speak, and a floor they understate is corrected",
          "[job]") {
  for (const char* hidden : {"backlash", "half_turn"}) {
    CAPTURE(hidden);
    Campaign campaign = measured_twice(hide(hidden, 28, 13).campaign, 0.001);
    campaign.tracker.reset();
    const Json d = diagnosed(campaign);
    CHECK(d["noise_source"] == "repeats");
    CHECK(d["noise_floor_mm"] > 0.0);
    CHECK_THAT(unbroken(diagnosis_text(d)), Contains("from repeated readings"));
  }
}

TEST_CASE("what the readings lack is said in words, and the workflow goes on", "[job]") {
  HiddenCase c = hide("backlash", 28, 3);
  std::vector<Reading> kept;
  for (Reading r : c.campaign.readings) {
    if (r.set == ReadingSet::validate) continue;
    if (std::abs(r.target.phi_rad) > 1e-9) continue;
    r.conditions.time_s.reset();
    r.conditions.temp_degc.reset();
    kept.push_back(r);
  }
  for (std::size_t k = kept.size() - 3; k < kept.size(); ++k) kept[k].conditions.epoch = 2;
  c.campaign.readings = kept;
  const Json d = diagnosed(c.campaign);
  const std::string notes = d["notes"].dump();
  for (const char* said : {"no validation readings", "one orientation", "epoch 2 has 3 readings",
                           "thermal_growth can't be tested", "tracker_drift can't be tested"}) {
    CHECK_THAT(notes, Contains(said));
  }
  CHECK(d["audit"].size() + 1 == effect_catalogue().size());  // a 3-PRR has no guide that yaws
  CHECK_THAT(unbroken(diagnosis_text(d)), Contains("none are left to judge"));
}
