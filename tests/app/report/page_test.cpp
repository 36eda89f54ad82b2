// The page's data and the file around it; what a browser makes of it is browser/page_test.mjs.

#include "app/report/page/page.hpp"

#include <fmt/format.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "store/open.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::run_program;

namespace {

/// The campaign drive-error, imported and calibrated by `methods`.
class Imported {
 public:
  explicit Imported(const std::vector<std::string>& methods) {
    run({"campaign", "import", tests::kDriveError});
    for (const std::string& method : methods) run({"calibrate", method, "drive-error"});
  }
  void run(const std::vector<std::string>& words) const {
    const tests::Finished finished = run_program(words, folder_.path());
    CAPTURE(words, finished.err);
    REQUIRE(finished.exit_code == 0);
  }
  [[nodiscard]] report::Json page() const {
    store::Connection db = store::open(folder_.path() / "trammel.db", store::Access::read_only);
    const store::CampaignRow campaign = store::require_campaign(db, "drive-error");
    return report::page_json(db, campaign, report::gather(db, campaign));
  }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

 private:
  tests::TemporaryFolder folder_;
};

using Items = std::map<std::string, report::Json>;

void take_items(const report::Json& of, Items& all) {
  for (const auto& item : of.at("items")) {
    const std::string id = item.at("id");
    CAPTURE(id);
    CHECK(all.emplace(id, item).second);
    if (item.contains("items")) take_items(item, all);
  }
}

/// Everything on the page by its id, what is folded too; each id stands once.
Items items(const report::Json& page) {
  Items all;
  for (const auto& section : page.at("sections")) take_items(section, all);
  return all;
}

double largest(const report::Json& values) {
  double most = 0;
  for (const auto& v : values) most = std::max(most, v.is_null() ? 0 : v.get<double>());
  return most;
}

}  // namespace

TEST_CASE("a page's data is valid against its schema, before and after any calibration",
          "[report]") {
  const Imported bare({});
  const auto page = bare.page();
  CHECK(tests::schema_errors(nlohmann::json::parse(page.dump()), "report-page.schema.json") == "");
  const auto of_bare = items(page);
  for (const char* id : {"before-after", "named", "methods", "circles", "network", "folds"}) {
    CAPTURE(id);
    CHECK(of_bare.at(id).at("absent").get<std::string>().size() > 10);
  }
  std::set<std::string> reasons;  // each stands once
  for (const auto& [id, item] : of_bare) {
    if (item.contains("absent")) CHECK(reasons.insert(item.at("absent")).second);
  }
  for (const char* id : {"headline", "gap", "residuals", "contest"}) CHECK(!of_bare.contains(id));
  CHECK(of_bare.at("mechanism").contains("data"));
  CHECK(of_bare.at("sensitivity").contains("data"));

  const Imported fitted({"lsq", "idw"});
  CHECK(tests::schema_errors(nlohmann::json::parse(fitted.page().dump()),
                             "report-page.schema.json") == "");
}

TEST_CASE("maps of one figure share one colour scale, which holds every error drawn", "[report]") {
  const Imported imported({"lsq", "idw"});
  std::set<double> scales;
  for (const auto& [id, item] : items(imported.page())) {
    if (item.value("kind", "") != "maps") continue;
    CAPTURE(id);
    const auto& data = item.at("data");
    scales.insert(data.at("max").get<double>());
    double most = 0;
    for (const auto& p : data.at("points")) {
      for (const std::size_t k : {std::size_t{2}, std::size_t{5}}) {
        most = std::max(most, std::hypot(p[k].get<double>(), p[k + 1].get<double>()));
      }
    }
    CHECK(most <= data.at("max").get<double>() + 1e-5);
    CHECK(most > 0.02);
    const auto& grid = data.at("grid");
    const auto n = grid.at("columns").get<std::size_t>() * grid.at("rows").get<std::size_t>();
    CHECK(grid.at("before").size() == n);
    CHECK(largest(grid.at("before")) > 0.5 * most);  // the surface goes through the points
  }
  CHECK(scales.size() == 1);
}

TEST_CASE("errors by point have the mean that the report's table says", "[report]") {
  const Imported imported({"lsq", "rbf"});
  const tests::Finished json = run_program({"report", "drive-error", "--json"}, imported.path());
  const auto of_page = items(imported.page());
  const auto report = nlohmann::json::parse(json.out);
  for (const auto& t : report.at("tables")) {
    const std::string id = "points-" + t.at("method").get<std::string>() + "-" +
                           std::to_string(t.at("before").at("n").get<int>()) + "-" +
                           t.at("figure").get<std::string>();
    CAPTURE(id);
    for (const char* side : {"before", "after"}) {
      const auto& values = of_page.at(id).at("data").at(side);
      double mean = 0;
      for (const auto& v : values) mean += v.get<double>() / static_cast<double>(values.size());
      CHECK_THAT(mean, WithinAbs(t.at(side).at("mean").get<double>(), 1e-5));
    }
  }
}

TEST_CASE(
    "the first screen has every warning that the calibrations print, and the chosen method first",
    "[report]") {
  const Imported imported({"lsq", "rbf"});
  imported.run({"diagnose", "drive-error"});
  const report::Json page = imported.page();
  const report::Json& first = page.at("sections").at(0);
  std::map<std::string, report::Json> shown;
  for (const auto& item : first.at("items")) shown[item.at("id")] = item;
  REQUIRE(shown.size() == 4);

  // Of the sentences that calibrate prints, those are warnings that say so or sound the alarm.
  std::string warned;
  for (const std::string line : shown.at("warnings").at("lines")) warned += line + "\n";
  int n = 0;
  for (const char* stage : {"lsq", "rbf"}) {
    const tests::Finished again =
        run_program({"calibrate", stage, "drive-error", "--json"}, imported.path());
    const auto printed = nlohmann::json::parse(again.out);
    for (const std::string sentence : printed.at("words")) {
      if (!sentence.starts_with("warning: ") && !sentence.starts_with("absorption alarm")) continue;
      ++n;
      const std::size_t from = sentence.find(": ") + 2;
      const std::string middle = sentence.substr(from, sentence.find(": ", from) - from);
      CHECK_THAT(warned, Contains(middle));
    }
  }
  CHECK(n > 0);
  CHECK_THAT(warned, Contains("lsq, rbf") || !Contains("nothing of these readings"));

  const auto& rows = shown.at("before-after").at("rows");
  const tests::Finished json = run_program({"report", "drive-error", "--json"}, imported.path());
  const auto report = nlohmann::json::parse(json.out);
  int n_chosen = 0;
  for (const auto& t : report.at("tables")) {
    if (t.at("figure") != "position" || t.at("judged") != "held-out") continue;
    if (!rows.at(0).at(0).get<std::string>().starts_with(t.at("method").get<std::string>()))
      continue;
    ++n_chosen;
    CHECK_THAT(rows.at(0).at(2).get<std::string>(),
               Contains(fmt::format("{:.4f}\n(", t.at("after").at("mean").get<double>())));
    CHECK_THAT(page.at("verdict").get<std::string>(),
               Contains(fmt::format("{:.4f} mm", t.at("after").at("mean").get<double>())));
  }
  CHECK(n_chosen == 1);
  CHECK_THAT(rows.at(0).at(3).get<std::string>(), Contains(" %\n(") && Contains(" to "));
  CHECK(shown.at("named").at("rows").at(0).at(1).get<std::string>().find("+-") !=
        std::string::npos);

  int open = 0;
  for (const auto& [id, item] : items(page)) open += item.value("open", false) ? 1 : 0;
  CHECK(open == 1);
}

TEST_CASE("points are asked for with orientation and approach, until they are measured",
          "[report]") {
  const tests::TemporaryFolder folder;
  const auto run = [&folder](const std::vector<std::string>& words) {
    const tests::Finished finished = run_program(words, folder.path());
    CAPTURE(words, finished.err);
    REQUIRE(finished.exit_code == 0);
  };
  const auto measure = [&run](const std::string& plan) {
    const std::string robot = "sim:" + tests::source_folder() + "/examples/paper/robot.json";
    run({"session", "run", "lab", "--plan", plan, "--session", plan, "--stage", robot});
  };
  const auto asked = [&folder] {
    store::Connection db = store::open(folder.path() / "trammel.db", store::Access::read_only);
    const store::CampaignRow lab = store::require_campaign(db, "lab");
    return items(report::page_json(db, lab, report::gather(db, lab))).at("next-points");
  };
  run({"plan", "create", "paper-80", "--out", "first.json"});
  measure("first.json");
  run({"diagnose", "lab"});
  const report::Json before = asked();
  REQUIRE(before.contains("data"));
  const report::Json& next = before.at("data").at("next");
  REQUIRE(next.size() > 3);
  for (const auto& point : next) {
    CHECK(point.at("approach").get<std::string>().find_first_not_of("+-0") == std::string::npos);
    CHECK(point.contains("phi_deg"));
  }

  run({"plan", "create", "next-points", "--campaign", "lab", "--out", "next.json"});
  report::Json plan = report::Json::parse(tests::read_text(folder.path() / "next.json"));
  plan.at("points").erase(plan.at("points").begin() + 2, plan.at("points").end());
  std::ofstream(folder.path() / "two.json") << plan.dump();
  measure("two.json");
  const report::Json after = asked();
  CHECK(after.at("data").at("next").size() == next.size() - 2);
  CHECK(after.at("data").at("next").at(0) == next.at(2));

  plan = report::Json::parse(tests::read_text(folder.path() / "next.json"));
  plan.at("points").erase(plan.at("points").begin(), plan.at("points").begin() + 2);
  int seq = 0;
  for (auto& point : plan.at("points")) point.at("seq") = ++seq;
  std::ofstream(folder.path() / "rest.json") << plan.dump();
  measure("rest.json");
  CHECK_THAT(asked().at("absent").get<std::string>(), Contains("are measured: diagnose again"));
}

TEST_CASE("a page is one file that names its style and script by hash and asks for nothing else",
          "[report]") {
  const Imported imported({"lsq"});
  imported.run({"report", "drive-error", "--html", "page.html"});
  const std::string html = tests::read_text(imported.path() / "page.html");
  CHECK(html.size() < 2'500'000);
  CHECK_THAT(html, Contains("default-src 'none'; script-src 'sha256-") &&
                       Contains("style-src 'sha256-") && !Contains("unsafe-") &&
                       !Contains("<link") && !Contains(" src=\""));
  for (const char* notice :
       {"Apache License", "echarts 6", "claygl 1", "zrender 6", "echarts-gl 2"})
    CHECK_THAT(html, Contains(notice));
  CHECK(html.find("<script", html.find("<script", html.find("<script") + 1) + 1) ==
        std::string::npos);

  imported.run({"report", "drive-error", "--html", "not-there.html", "--dry-run"});
  CHECK_FALSE(std::filesystem::exists(imported.path() / "not-there.html"));
}

TEST_CASE("JSON inside a script element can neither end it nor begin a comment", "[report]") {
  const report::Json hostile = {{"a", "</script><!-- \u2028 \u2029 & <b>"}, {"b", "\xff broken"}};
  const std::string text = report::script_json(hostile);
  CHECK(text.find_first_of("<>&") == std::string::npos);
  CHECK(text.find("\xe2\x80\xa8") == std::string::npos);
  const auto back = nlohmann::json::parse(text);
  CHECK(back.at("a") == hostile.at("a"));

  report::Json page = {{"campaign", "</title><script>alert(1)</script>"},
                       {"kind", "simulated"},
                       {"verdict", "\"'<img src=x>@DATA@"},
                       {"sections", report::Json::array()}};
  const std::string html = report::page_html(page);
  CHECK_THAT(html, Contains("&lt;/title&gt;&lt;script&gt;alert(1)") &&
                       Contains("&quot;&#39;&lt;img src=x&gt;@DATA@") &&
                       Contains("<div class=\"simulated\">SIMULATED</div>"));
  page["campaign"] =
      "a\u202Eb\xc2\x9b"
      "c";
  page["sections"] = {{{"text", "d\u2066e\nf\u200F"}}};
  const std::string turned = report::page_html(page);
  CHECK_THAT(turned, Contains("Campaign a?b?c") && Contains("\"d?e\\nf?\""));
  for (const char* sign :
       {"\u202E", "\u2066", "\u200F", "\xc2\x9b", "\\u202e", "\\u2066", "\\u200f", "\\u009b"}) {
    CHECK_THAT(turned, !Contains(sign));
  }
  page["kind"] = "real";
  CHECK(report::page_html(page).find(">SIMULATED<") == std::string::npos);
}
