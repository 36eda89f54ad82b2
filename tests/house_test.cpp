// The tree keeps its own rules: which folder may include which, proofs that exist, one definition
// of what a fit has seen.

#include <array>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"

using namespace trammel;

namespace {

/// From below to above: a folder includes only folders that stand before it.
const std::vector<std::string> kFolders = {
    "core",           "core/linear",   "core/statistics", "core/plane",    "core/mechanism",
    "core/measure",   "core/model",    "core/plan",       "core/simulate", "core/judge",
    "core/calibrate", "core/diagnose", "store",           "app/files",     "app/terminal",
    "app/device",     "app/emulate",   "app/session",     "app/job",       "app/report",
    "app/protocol",   "app/serve",     "app/cli",         "app/archive",   "app"};

struct Source {
  std::filesystem::path path;  // in the tree
  std::string text;
};

std::vector<Source> sources() {
  const std::filesystem::path root = tests::source_folder();
  std::vector<Source> all;
  for (const char* top : {"core", "store", "app"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".hpp" && extension != ".cpp") continue;
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      all.push_back({std::filesystem::relative(entry.path(), root), text.str()});
    }
  }
  return all;
}

/// "app/report" for app/report/page/maps.cpp.
std::string folder_of(const std::filesystem::path& path) {
  auto part = path.begin();
  const std::string top = *part++;
  if (top == "store" || std::next(part) == path.end()) return top;
  return top + "/" + part->string();
}

long place_of(const std::string& folder) {
  const auto at = std::find(kFolders.begin(), kFolders.end(), folder);
  return at == kFolders.end() ? -1 : at - kFolders.begin();
}

std::vector<std::string> matches(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
    found.push_back((*at)[1]);
  }
  return found;
}

}  // namespace

TEST_CASE("no folder includes one above it", "[house]") {
  static const std::regex kInclude("#include \"((?:core|store|app)/[^\"]+)\"");
  int n_seen = 0;
  for (const Source& source : sources()) {
    const std::string from = folder_of(source.path);
    CAPTURE(source.path.string());
    CHECK(place_of(from) >= 0);
    for (const std::string& included : matches(source.text, kInclude)) {
      CAPTURE(included);
      CHECK(place_of(folder_of(included)) >= 0);
      CHECK(place_of(folder_of(included)) <= place_of(from));
      ++n_seen;
    }
  }
  CHECK(n_seen > 500);
}

TEST_CASE("every test that a comment names as proof exists", "[house]") {
  static const std::regex kTest("\\b([a-z0-9_]+_test\\.(?:cpp|mjs))");
  std::set<std::string> tests;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(
           std::filesystem::path(tests::source_folder()) / "tests")) {
    tests.insert(entry.path().filename());
  }
  int n_seen = 0;
  for (const Source& source : sources()) {
    for (const std::string& named : matches(source.text, kTest)) {
      CAPTURE(source.path.string(), named);
      CHECK(tests.count(named) == 1);
      ++n_seen;
    }
  }
  CHECK(n_seen > 100);
}

TEST_CASE("heavy headers stay where they are wrapped", "[house]") {
  // Each costs seconds in every file that reads it: CLI11 6 to 8, a solver of Eigen 2 to 10.
  struct Rule {
    std::regex include;
    std::set<std::string> folders;
  };
  const std::array<Rule, 2> rules = {{
      {std::regex("#include <(CLI/[^>]+)>"), {"app/cli"}},
      {std::regex("#include <(Eigen/(?:SVD|QR|Cholesky|Eigenvalues|LU|Dense))>"), {"core/linear"}},
  }};
  for (const Source& source : sources()) {
    for (const Rule& rule : rules) {
      for (const std::string& header : matches(source.text, rule.include)) {
        CAPTURE(source.path.string(), header);
        CHECK(rule.folders.count(folder_of(source.path)) == 1);
        CHECK((header.find("CLI/") != 0 || source.path.extension() == ".cpp"));
      }
    }
  }
}

TEST_CASE("every file and folder that CONTRIBUTING names is there", "[house]") {
  static const std::regex kPath(
      "`((?:core|store|app|tests|scripts|schemas|examples)/[a-zA-Z0-9_./-]*)`");
  const std::filesystem::path root = tests::source_folder();
  std::ostringstream text;
  text << std::ifstream(root / "CONTRIBUTING.md").rdbuf();
  int n_seen = 0;
  for (const std::string& path : matches(text.str(), kPath)) {
    if (path.find("NAME") != std::string::npos || path.find("NNNN") != std::string::npos) continue;
    CAPTURE(path);
    CHECK(std::filesystem::exists(root / path));
    ++n_seen;
  }
  CHECK(n_seen > 15);
}
