// The page's data and the file around it; what a browser makes of it is browser/page_test.mjs.

#include "app/report/page/page.hpp"

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
    return report::page_json(db, store::require_campaign(db, "drive-error"));
  }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

 private:
  tests::TemporaryFolder folder_;
};

/// Every figure and table of the page by its id; each id stands once.
std::map<std::string, report::Json> items(const report::Json& page) {
  std::map<std::string, report::Json> all;
  for (const auto& section : page.at("sections")) {
    for (const auto& item : section.at("items")) {
      const std::string id = item.at("id");
      CAPTURE(id);
      CHECK(all.emplace(id, item).second);
    }
  }
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
  for (const char* id : {"headline", "maps", "circles", "network", "gap", "contest"}) {
    CAPTURE(id);
    CHECK(of_bare.at(id).at("absent").get<std::string>().size() > 10);
  }
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

TEST_CASE("a page is one file that names its style and script by hash and asks for nothing else",
          "[report]") {
  const Imported imported({"lsq"});
  imported.run({"report", "drive-error", "--html", "page.html"});
  const std::string html = tests::read_text(imported.path() / "page.html");
  CHECK(html.size() < 2'500'000);
  CHECK_THAT(html, Contains("default-src 'none'; script-src 'sha256-") &&
                       Contains("style-src 'sha256-") && !Contains("unsafe-") &&
                       !Contains("<link") && !Contains(" src=\""));
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
