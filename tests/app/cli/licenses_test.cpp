// What the build really links is what `trammel licenses` names, and the page and the package with
// it.

#include "app/cli/licenses.hpp"

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "app/report/page/page.hpp"
#include "store/provenance.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_command;
using tests::run_here;

namespace {

std::string output_of(const std::vector<std::string>& words) {
  const Finished done = run_command(words, tests::build_folder());
  INFO(done.err.substr(0, 500));
  REQUIRE(done.exit_code == 0);
  return done.out;
}

/// Files of the system that objects of the program were compiled from or linked with.
std::set<std::string> system_files() {
  std::set<std::string> files;
  std::istringstream deps(output_of({"ninja", "-t", "deps"}));
  bool ours = false;
  for (std::string line; std::getline(deps, line);) {
    if (!line.starts_with("    ")) {
      // trammel-archive is linked with libpq as the system has it, which comes with its own terms.
      ours =
          (line.starts_with("core/") || line.starts_with("store/") || line.starts_with("app/")) &&
          !line.starts_with("app/archive/");
    } else if (ours && line.starts_with("    /usr/")) {
      files.insert(line.substr(4));
    }
  }
  const std::string commands = output_of({"ninja", "-t", "commands", "-s", "trammel"});
  std::istringstream link(commands);
  for (std::string word; link >> word;) {
    if (word.starts_with("/usr/") && word.ends_with(".a")) files.insert(word);
  }
  return files;
}

/// Debian's source packages of the files, without those that are part of every system: libc, the
/// kernel's headers.
std::set<std::string> sources_of(const std::set<std::string>& files) {
  std::vector<std::string> search = {"dpkg-query", "-S"};
  search.insert(search.end(), files.begin(), files.end());
  std::istringstream owners(run_command(search, tests::build_folder()).out);
  std::set<std::string> packages, sources;
  for (std::string line; std::getline(owners, line);)
    packages.insert(line.substr(0, line.find(": ")));
  for (const std::string& package : packages) {
    sources.insert(output_of({"dpkg-query", "-W", "-f", "${source:Package}", package}));
  }
  std::erase_if(sources, [](const std::string& s) { return s == "glibc" || s == "linux"; });
  return sources;
}

std::set<std::string> built_using() {
  std::string text = tests::read_text(tests::build_folder() + "/built-using");
  std::set<std::string> sources;
  std::istringstream in(text);
  for (std::string source; std::getline(in, source, ',');) {
    const std::size_t first = source.find_first_not_of(' ');
    sources.insert(source.substr(first, source.find(' ', first) - first));
  }
  return sources;
}

}  // namespace

TEST_CASE("every library that the build reads or links is named with its terms, and no other",
          "[cli][release]") {
  for (const char* tool : {"ninja", "dpkg-query"}) {
    if (run_command({"sh", "-c", std::string("command -v ") + tool}, "/").exit_code != 0) {
      return tests::skip_without(tool);
    }
  }
  CHECK(sources_of(system_files()) == built_using());
  const auto libraries = cli::libraries();
  CHECK(libraries.size() >= built_using().size() + 4);
  for (const cli::Library& l : libraries) {
    CAPTURE(l.name, l.version);
    CHECK(l.version.find_first_of("0123456789") == 0);
    CHECK(l.terms.size() > 50);
  }
}

TEST_CASE("the page carries the notices of what it is bundled with, folded, at its end",
          "[report]") {
  const std::string page =
      report::page_html({{"campaign", "a"}, {"kind", "real"}, {"verdict", "b"}});
  const std::size_t at = page.find("<details id=\"notices\">");
  REQUIRE(at != std::string::npos);
  CHECK(at > page.find("<main"));
  const std::string notices = page.substr(at, page.find("</details>", at) - at);
  for (const char* name : {"claygl", "echarts", "echarts-gl", "zrender"}) {
    CAPTURE(name);
    CHECK_THAT(notices, Contains("<h3>" + std::string(name) + " "));
  }
  for (const char* words : {"The Apache Software Foundation", "Apache License", "Yi Shen",
                            "Redistributions in binary form must reproduce"}) {
    CAPTURE(words);
    CHECK_THAT(notices, Contains(words));
  }
}

TEST_CASE("the program prints its own terms first, and its version with its libraries'", "[cli]") {
  const Finished text = run_here({"licenses"});
  CHECK(text.out.find("Trammel " + store::this_program().tool_version) < 100);
  for (const char* words : {"2013-2022 Niels Lohmann", "Victor Zverovich", "claygl"}) {
    CAPTURE(words);
    CHECK_THAT(text.out, Contains(words));
  }
  const Finished version = run_here({"--version", "--json"});
  CHECK(version.exit_code == 0);
  const auto json = nlohmann::json::parse(version.out);
  CHECK(tests::schema_errors(json, "version.schema.json") == "");
  CHECK(json.at("libraries").size() == cli::libraries().size());
  CHECK(run_here({"--version"}).out == "trammel " + json.at("version").get<std::string>() + "\n");
}
