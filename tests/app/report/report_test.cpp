// A campaign this project's simulator did not make: imported, calibrated by all three, reported.

#include <nlohmann/json.hpp>

#include "app/files/json_file.hpp"
#include "app/files/published_json.hpp"
#include "app/report/remarks.hpp"
#include "app/report/report.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::run_program;

namespace {

using Answer = nlohmann::json;

const Answer& table(const Answer& report, const std::string& id) {
  for (const Answer& t : report.at("tables")) {
    if (t.at("id") == id) return t;
  }
  throw std::runtime_error("no table " + id);
}

}  // namespace

TEST_CASE("an imported campaign is calibrated by all three methods, and the report says predicted",
          "[report]") {
  const tests::TemporaryFolder folder;
  const auto run = [&folder](const std::vector<std::string>& words) {
    const tests::Finished finished = run_program(words, folder.path());
    CAPTURE(words, finished.err);
    REQUIRE(finished.exit_code == 0);
    return finished.out;
  };
  run({"campaign", "import", tests::source_folder() + "/tests/support/campaigns/drive-error"});
  for (const char* method : {"lsq", "idw", "rbf"}) run({"calibrate", method, "drive-error"});
  const Answer report = Answer::parse(run({"report", "drive-error", "--json"}));

  CHECK(report.at("schema") == "trammel/report/1");
  CHECK(report.at("campaign") == "drive-error");
  CHECK_THAT(report.at("floor_mean_mm").get<double>(), WithinRel(0.0125331, 1e-5));
  for (const char* figure : {"position", "attitude"}) {
    const Answer& lsq = table(report, std::string("lsq-80-") + figure);
    CHECK(lsq.at("in_sample") == true);
    CHECK(lsq.at("after_is") == "predicted");
    CHECK(lsq.at("before").at("n") == 80);
    CHECK(lsq.at("after").at("mean") < lsq.at("before").at("mean"));
    for (const char* method : {"idw", "rbf"}) {
      const Answer& held_out = table(report, std::string(method) + "-48-" + figure);
      CHECK(held_out.at("in_sample") == false);
      CHECK(held_out.at("before").at("n") == 48);
      CHECK(held_out.at("after").at("mean") < held_out.at("before").at("mean"));
      const double before = held_out.at("before").at("mean"),
                   after = held_out.at("after").at("mean");
      CHECK_THAT(held_out.at("improvement_pct").get<double>(),
                 WithinAbs(100 * (1 - after / before), 1e-9));
    }
  }
  // One baseline: both methods start from the same readings.
  CHECK(table(report, "idw-48-position").at("before") ==
        table(report, "rbf-48-position").at("before"));
  CHECK_FALSE(table(report, "idw-48-position").contains("paper"));  // another robot's figures
  CHECK(report.at("contest").at("n") == 48);
  CHECK(report.at("identification").at("rank") == 12);
  CHECK(report.at("identification").at("columns") == 18);
  CHECK(report.at("chain_head").get<std::string>().size() == 64);
  for (const Answer& p : report.at("identification").at("parameters")) {
    CAPTURE(p.at("name"));
    CHECK(p.at("value").is_number() == p.at("identified").get<bool>());
    CHECK_FALSE(p.contains("paper"));
  }

  // Figs. 7 and 8: what constants cannot follow is left, in-sample and held-out.
  const Answer& simulation = report.at("simulation");
  REQUIRE(simulation.size() == 2);
  CHECK(simulation[0].at("in_sample") == true);
  CHECK(simulation[1].at("in_sample") == false);
  for (const Answer& s : simulation) {
    CHECK(s.at("left_mean_mm") < s.at("measured_mean_mm"));
    int n = 0;
    for (const Answer& ring : s.at("rings")) n += ring.at("n").get<int>();
    CHECK(n == s.at("n").get<int>());
  }
  // Errors count from where the command leads there, from the target here.
  CHECK_THAT(simulation[0].at("measured_mean_mm").get<double>(),
             WithinAbs(table(report, "lsq-80-position").at("before").at("mean"), 1e-8));

  const Answer same = Answer::parse(run({"compare", "drive-error", "drive-error", "--json"}));
  CHECK(same.at("tables").size() == report.at("tables").size());
  for (const Answer& t : same.at("tables")) CHECK(t.at("after_mean_difference") == 0.0);

  const std::string text = run({"report", "drive-error"});
  CHECK_THAT(text, Contains("predicted from the readings before, not measured again"));
  CHECK_THAT(text, Contains("rank 12 of 18"));
  CHECK_THAT(text, Contains("perfect reading"));
  // Each combination has the U that the calibration states, k = 2, and stands in the text once.
  int n_combinations = 0;
  for (const std::string sentence : report.at("identification").at("words")) {
    if (!sentence.starts_with("identified of these: ")) continue;
    const std::size_t at = sentence.find("+- ");
    const std::string U = sentence.substr(at, sentence.find(' ', at + 3) - at);
    CAPTURE(sentence);
    REQUIRE(text.find(U) != std::string::npos);
    CHECK(text.find(U, text.find(U) + 1) == std::string::npos);
    ++n_combinations;
  }
  CHECK(n_combinations > 3);
  CHECK_THAT(text, !Contains("one standard"));
  CHECK_THAT(text, !Contains("0.3707") && !Contains("paper"));
  CHECK_THAT(text, !Contains("dropped"));

  run({"calibrate", "lsq", "drive-error", "--drop-below", "2"});
  CHECK_THAT(run({"report", "drive-error"}),
             Contains("dropped mm") && Contains("dropped as small"));
}

TEST_CASE("a campaign without calibration has a report that says so", "[report]") {
  const tests::TemporaryFolder folder;
  run_program(
      {"campaign", "import", tests::source_folder() + "/tests/support/campaigns/drive-error"},
      folder.path());
  CHECK_THAT(run_program({"report", "drive-error"}, folder.path()).out,
             Contains("no calibration yet"));
  CHECK(run_program({"report", "nobody"}, folder.path()).exit_code == 3);
}

TEST_CASE("published figures are stored with the campaign that has them, and shown for no other",
          "[report]") {
  const auto protocol =
      Answer::parse(tests::read_text(tests::source_folder() + "/examples/paper/protocol.json"));
  const JsonFile file = parse_json(protocol.dump(), "protocol");
  Fields fields(file);
  Campaign campaign;
  CHECK_FALSE(published_of(campaign));
  campaign.facts[kPublishedFact] = read_published(fields.object("published"));
  const auto printed = published_of(campaign);
  REQUIRE(printed);
  CHECK(printed->tables.size() == 6);
  CHECK(printed->tables[0].after[0] == 0.0241);
  CHECK(printed->tables[0].in_sample);
  CHECK_FALSE(printed->tables[2].in_sample);
  CHECK(printed->parameters.at("l_2") == 0.3707);
  Answer wrong = protocol["published"];
  wrong["tables"][0]["after"] = {1, 2};
  const JsonFile bad = parse_json(wrong.dump(), "published");
  CHECK_THROWS_WITH(read_published(Fields(bad)), Contains("three numbers"));
}

TEST_CASE("a method is said to make an error worse only where the points show it", "[report]") {
  const auto remarks = [](const std::vector<double>& before, const std::vector<double>& after) {
    report::ErrorTable table{.method = "idw", .figure = "position", .unit = "mm"};
    for (std::size_t k = 0; k < before.size(); ++k) {
      table.points.push_back({.before = before[k], .after = after[k]});
    }
    table.before = summarise(before);
    table.after = summarise(after);
    report::Report report;
    report.tables.push_back(table);
    return report::remarks_on(report);
  };
  CHECK(remarks({0.003, 0.0030001}, {0.003, 0.0030002}).empty());    // two points show nothing
  CHECK(remarks({1, 2, 3, 4, 5, 6}, {2, 1, 4, 3, 6, 5.6}).empty());  // up and down
  const auto worse = remarks({1, 2, 3, 4, 5, 6}, {1.5, 2.6, 3.4, 4.5, 5.6, 6.5});
  REQUIRE(worse.size() == 1);
  CHECK_THAT(worse[0], Contains("idw makes position worse: mean 3.5000 -> 4.0167 mm"));
}
