// One of a thing is printed in the singular, in whatever sentence it stands.

#include <regex>
#include <sstream>

#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::run_here;

namespace {

/// "1 readings" of a text; empty: none.
std::string wrong_plural(const std::string& text) {
  static const std::regex pattern(
      R"((^|[^0-9.,])1 (fitted |held-out |in-sample |unseen |other )?(readings|points|rows|sessions|jobs|places|epochs|targets|runs|poses|steps|columns|parameters|combinations|drives|plans|records|others|neurons|visits|models|effects|tests|times)\b)");
  std::smatch found;
  return std::regex_search(text, found, pattern) ? found.str() : "";
}

/// The first `n` readings of the template: its header and so many lines, the last one to judge.
std::string readings(const std::string& all, int n) {
  std::istringstream lines(all);
  std::string text, line;
  for (int k = 0; k <= n && std::getline(lines, line); ++k) {
    if (k == n && n > 1) line.replace(line.find("identify"), 8, "validate");
    text += line + "\n";
  }
  return text;
}

}  // namespace

TEST_CASE("one reading, point, session, job or row is printed in the singular", "[cli]") {
  CHECK(wrong_plural("of 1 readings") == " 1 readings");
  CHECK(wrong_plural("21 readings, 0.1 points, 1 reading").empty());
  const tests::TemporaryFolder folder;
  const auto run = [&folder](const std::vector<std::string>& words) {
    const auto done = run_here(words, folder.path());
    CAPTURE(words, done.out, done.err);
    CHECK(wrong_plural(done.out + done.err) == "");
    return done;
  };
  const std::string all = run_here({"template", "campaign", "readings"}).out;
  REQUIRE(run({"template", "campaign", "--out", "campaign.json"}).exit_code == 0);
  REQUIRE(run({"template", "robot", "xy", "--out", "xy.json"}).exit_code == 0);
  for (const int n : {1, 2, 5}) {
    CAPTURE(n);
    const std::string name = "of " + std::to_string(n);
    folder.write("readings.csv", readings(all, n));
    REQUIRE(run({"campaign", "import", ".", "--name", name}).exit_code == 0);
    for (const char* method : {"lsq", "geometry", "idw", "rbf", "gp", "hybrid"}) {
      run({"calibrate", method, name});
    }
    for (const char* command : {"diagnose", "assess", "report"}) run({command, name});
    run({"report", name, "--html", name + ".html"});
    run({"campaign", "show", name});
    run({"campaign", "check", name});
    run({"campaign", "export", name, "--dry-run", "--out", "copy"});
    run({"complete", "--", "report", ""});
    run({"db", "verify"});
  }
  for (const char* job : {"1", "2", "3", "4"}) {
    for (const char* verb : {"show", "why", "verify"}) run({"job", verb, job});
  }
  run({"job", "diff", "1", "2"});
  run({"plan", "create", "lattice", "--step", "90", "--half-width", "1", "--out", "one.json"});
  run({"plan", "check", "one.json", "--mechanism", "xy.json"});
  run({"session", "run", "lab", "--plan", "one.json", "--stage", "sim:xy.json", "--dry-run"});
  REQUIRE(
      run({"session", "run", "lab", "--plan", "one.json", "--stage", "sim:xy.json"}).exit_code ==
      0);
  for (const char* verb : {"status", "resume", "recover"}) run({"session", verb, "lab"});
  folder.write("protocol.json", R"({"format": "protocol/1", "name": "short", "stage": "sim:xy.json",
    "steps": [{"name": "fit", "kind": "measure", "plan": "one.json"}]})");
  for (const char* more : {"--dry-run", "--quiet"}) run({"protocol", "run", "protocol.json", more});
  run({"report", "short"});
}
