// `report --tolerance`: the same decision in text, JSON, page and exit code.

#include "app/report/tolerance.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/report/gather.hpp"
#include "app/report/page/page.hpp"
#include "store/open.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_here;

namespace {

/// The drive error, imported; with lsq where `calibrated`.
struct ToleranceLab {
  tests::TemporaryFolder folder;
  explicit ToleranceLab(bool calibrated) {
    REQUIRE(run({"campaign", "import", tests::kDriveError}).exit_code == 0);
    if (calibrated) REQUIRE(run({"calibrate", "lsq", "drive-error"}).exit_code == 0);
  }
  [[nodiscard]] Finished run(std::vector<std::string> words) const {
    words.insert(words.end(), {"--db", "a.db"});
    return run_here(words, folder.path());
  }
  [[nodiscard]] nlohmann::json tolerance(const std::string& mm, int exit_code) const {
    const Finished done = run({"report", "drive-error", "--tolerance", mm, "--json"});
    INFO(done.err);
    CHECK(done.exit_code == exit_code);
    const auto report = nlohmann::json::parse(done.out);
    CHECK(tests::schema_errors(report, "report.schema.json") == "");
    return report.at("tolerance");
  }
};

}  // namespace

TEST_CASE("without a calibration the machine as it is is judged by the noise of a reading",
          "[report]") {
  const ToleranceLab lab(false);
  CHECK(lab.tolerance("5", 0).at("machine") == "passes");
  const auto fails = lab.tolerance("0.001", 5);
  CHECK(fails.at("machine") == "fails");
  CHECK(fails.at("method") == "");
  CHECK(fails.at("points").size() == 128);
  for (const auto& p : fails.at("points")) {
    CHECK_THAT(p.at("U_k2_mm").get<double>(), WithinAbs(0.02, 1e-12));  // twice 0.01
  }
}

TEST_CASE("U of a real campaign stands on the budget that it states, instrument and all",
          "[report]") {
  ToleranceLab lab(false);
  const std::filesystem::path real = lab.folder.path() / "real";
  std::filesystem::copy(tests::kDriveError, real);
  auto campaign = nlohmann::json::parse(tests::read_text(real / "campaign.json"));
  campaign["name"] = "real";
  campaign["kind"] = "real";
  campaign["facts"]["budget"] = {{"instrument_u_mm", 0.004},    {"nests_mm", 0.006},
                                 {"frame_u_mm", 0.003},         {"alpha_per_k", 1e-5},
                                 {"temperature_spread_k", 1.5}, {"length_mm", 700}};
  std::ofstream(real / "campaign.json") << campaign.dump();
  REQUIRE(lab.run({"campaign", "import", "real"}).exit_code == 0);
  const Finished done = lab.run({"report", "real", "--tolerance", "5", "--json"});
  INFO(done.err);
  REQUIRE(done.exit_code == 0);
  // By hand (GUM): reading 0.010; instrument, nests / sqrt 3, frame, alpha L dT / sqrt 3.
  const double u_mm = std::sqrt(0.010 * 0.010 + 0.004 * 0.004 + 0.006 * 0.006 / 3 + 0.003 * 0.003 +
                                std::pow(1e-5 * 700 * 1.5, 2) / 3);
  for (const auto& p : nlohmann::json::parse(done.out).at("tolerance").at("points")) {
    CHECK_THAT(p.at("U_k2_mm").get<double>(), WithinAbs(2 * u_mm, 1e-12));
  }
}

TEST_CASE("every point is decided by its own error and U, in JSON, text and page alike",
          "[report]") {
  const ToleranceLab lab(true);
  const auto found = lab.tolerance("0.05", 5);
  CHECK(found.at("method") == "lsq");
  CHECK(found.at("error_is") == "predicted");
  int n_passes = 0;
  for (const auto& p : found.at("points")) {
    if (p.at("U_k2_mm").is_null()) {  // beyond the range that was fitted
      CHECK(p.at("verdict") == "undecided");
      continue;
    }
    const double error_mm = p.at("error_mm"), U_mm = p.at("U_k2_mm");
    CHECK(U_mm > 0.02);  // more than the noise of a reading
    const char* expected = error_mm + U_mm <= 0.05  ? "passes"
                           : error_mm - U_mm > 0.05 ? "fails"
                                                    : "undecided";
    CHECK(p.at("verdict") == expected);
    n_passes += p.at("verdict") == "passes" ? 1 : 0;
  }
  CHECK(found.at("n_passes") == n_passes);
  const std::string words = found.at("words");
  const Finished text = lab.run({"report", "drive-error", "--tolerance", "0.05"});
  CHECK(text.exit_code == 5);
  CHECK_THAT(text.out, Contains("Against a tolerance of 0.05 mm it ") &&
                           Contains("Position error within 0.05 mm?") && Contains("ISO 14253-1"));
  const Finished html =
      lab.run({"report", "drive-error", "--tolerance", "0.05", "--html", "a.html"});
  CHECK(html.exit_code == 5);
  CHECK_THAT(tests::read_text(lab.folder.path() / "a.html"), Contains(words));
  store::Connection db = store::open(lab.folder.path() / "a.db", store::Access::read_only);
  const auto campaign = store::require_campaign(db, "drive-error");
  report::Gathered gathered = report::gather(db, campaign);
  const auto without = report::page_json(db, campaign, gathered);
  gathered.report.tolerance =
      report::tolerance_test(report::judged_points(db, campaign, gathered), 0.05);
  const auto page = report::page_json(db, campaign, gathered);
  CHECK(tests::schema_errors(nlohmann::json::parse(page.dump()), "report-page.schema.json") == "");
  REQUIRE(page.at("sections")[1].at("id") == "tolerance");
  CHECK(page.at("sections")[1].at("items")[0].at("rows").size() == found.at("points").size());
  CHECK(page.at("sections").size() == without.at("sections").size() + 1);
}

TEST_CASE(
    "a report becomes a calibration certificate in the form of DCC 3.3.0, with U and k of each "
    "point",
    "[report]") {
  const ToleranceLab lab(true);
  REQUIRE(lab.run({"report", "drive-error", "--dcc", "a.xml"}).exit_code == 0);
  const std::string xml = tests::read_text(lab.folder.path() / "a.xml");
  const auto count = [&xml](const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = xml.find(what); at != std::string::npos; at = xml.find(what, at + 1)) ++n;
    return n;
  };
  const nlohmann::json judged = lab.tolerance("0.05", 5);
  const auto n_points = static_cast<std::size_t>(std::ranges::count_if(
      judged.at("points"), [](const auto& p) { return !p.at("U_k2_mm").is_null(); }));
  CHECK(n_points > 0);
  CHECK(count("<si:valueExpandedMU>") == n_points);
  CHECK(count("<si:coverageFactor>2<") == n_points);
  CHECK_THAT(xml, Contains("Budget of U") && Contains("SIMULATED") && Contains("temperature"));
  CHECK(lab.run({"campaign", "export", "drive-error", "--out", "as-files"}).exit_code == 0);
  // Names are text, whatever they hold.
  REQUIRE(lab.run({"campaign", "import", "as-files", "--name", "<&\"' ]]> \x01"}).exit_code == 0);
  REQUIRE(lab.run({"report", "<&\"' ]]> \x01", "--dcc", "b.xml"}).exit_code == 0);
  if (tests::run_command({"sh", "-c", "command -v xmllint"}, "/").exit_code != 0) {
    return tests::skip_without("xmllint");
  }
  const auto lint = [&lab](const char* file) {
    return tests::run_command({"xmllint", "--noout", "--relaxng",
                               tests::source_folder() + "/tests/app/report/certificate.rng", file},
                              lab.folder.path());
  };
  for (const char* file : {"a.xml", "b.xml"}) {
    const Finished linted = lint(file);
    INFO(linted.err);
    CHECK(linted.exit_code == 0);
  }
  // Control: a condition without its data, which DCC demands.
  const std::size_t from = xml.find("<dcc:data>"), to = xml.find("</dcc:data>") + 11;
  std::ofstream(lab.folder.path() / "c.xml") << xml.substr(0, from) + xml.substr(to);
  CHECK(lint("c.xml").exit_code != 0);
}

TEST_CASE("the text report gives each identified combination once", "[report]") {
  const ToleranceLab lab(true);
  const std::string text = lab.run({"report", "drive-error"}).out;
  CHECK_THAT(text, !Contains("identified of these"));
  const std::size_t first = text.find("\n  l_1 - R_1 + 2 r_1 ");
  REQUIRE(first != std::string::npos);
  CHECK(text.find("l_1 - R_1 + 2 r_1 = ") == std::string::npos);
}
