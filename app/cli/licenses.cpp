#include "app/cli/licenses.hpp"

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "app/cli/license_texts.hpp"
#include "app/report/page/page.hpp"
#include "store/provenance.hpp"

namespace trammel::cli {

namespace {

struct LicensesOptions {};

std::string titled(const std::string& title, std::string_view terms) {
  return fmt::format("{0:=<{1}}\n{2}\n{0:=<{1}}\n\n{3}\n", "", title.size(), title, terms);
}

ExitCode run_licenses(const LicensesOptions&, Context& context) {
  const std::vector<Library> all = libraries();
  if (context.json) {
    Json list = Json::array();
    for (const Library& l : all) {
      list.push_back({{"name", l.name}, {"version", l.version}, {"terms", l.terms}});
    }
    context.print("licenses", {{"terms", kOwnTerms}, {"libraries", list}});
    return ExitCode::ok;
  }
  std::string text = titled("Trammel " + store::this_program().tool_version, kOwnTerms);
  for (const Library& l : all) text += "\n" + titled(l.name + " " + l.version, l.terms);
  context.print_as_is(text);
  return ExitCode::ok;
}

}  // namespace

std::vector<Library> libraries() {
  std::vector<Library> all;
  for (const LicenseText& l : license_texts()) {
    all.push_back({std::string(l.name), std::string(l.version), l.terms});
  }
  for (const report::PageLibrary& l : report::page_libraries()) {
    all.push_back({l.name, l.version, l.terms});
  }
  return all;
}

Json version_json() {
  const store::Provenance program = store::this_program();
  Json list = Json::array();
  for (const Library& l : libraries()) list.push_back({{"name", l.name}, {"version", l.version}});
  return {{"version", program.tool_version},
          {"git_revision", program.git_revision},
          {"compiler", program.compiler},
          {"cpu_level", program.cpu_level},
          {"libraries", list}};
}

void setup_licenses(Command app, Context& context) {
  on_run(app.command("licenses", "The terms of this program and of all libraries in it"), context,
         std::make_shared<LicensesOptions>(), run_licenses);
}

}  // namespace trammel::cli
