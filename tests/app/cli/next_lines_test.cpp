// Each line behind "next: ", run as it stands after the command that printed it: it parses, and is
// about the same machine, database and campaign.

#include <algorithm>
#include <cctype>
#include <map>
#include <sstream>

#include "app/terminal/text.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_here;
using Words = std::vector<std::string>;

namespace {

const std::string kXy = tests::source_folder() + "/examples/xy-stage/robot.json";
const std::string kUvw = tests::source_folder() + "/examples/uvw-stage/robot.json";
constexpr int kUsage = 2, kNotAcceptable = 5;

/// A campaign of an XY stage from its plan to its model, in an order that works; some lines fail.
std::vector<Words> lines() {
  const Words fit = {"plan",   "create",      "lattice", "--half-width", "90",
                     "--step", "45",          "--name",  "fit it",       "--approach",
                     "++,--",  "--mechanism", "xy.json"};
  Words fit_out = fit;
  fit_out.insert(fit_out.end(), {"--out", "fit it.json"});
  return {
      {"template", "machine", "xy"},
      {"mechanism", "check", "xy.json"},
      {"mechanism", "ik", "xy.json", "--pose", "1", "2"},
      {"mechanism", "ik", "xy.json", "--pose", "900", "2"},
      {"mechanism", "fk", "xy.json", "--l", "-1", "2"},
      {"mechanism", "sensitivity", "xy.json"},
      {"mechanism", "workspace", "xy.json"},
      {"mechanism", "workspace", "uvw.json"},
      {"mechanism", "workspace", "xy.json", "--half-width", "60", "--step", "30"},
      fit,
      fit_out,
      {"plan", "show", "fit it.json"},
      {"plan", "check", "fit it.json"},
      {"plan", "check", "fit it.json", "--mechanism", "xy.json"},
      {"plan", "check", "fit it.json", "--mechanism", "uvw.json"},
      {"session", "run", "my lab", "--plan", "fit it.json", "--stage", "sim:xy.json", "--dry-run"},
      {"session", "run", "my lab", "--plan", "fit it.json", "--stage", "sim:uvw.json"},
      {"session", "run", "my lab", "--plan", "fit it.json", "--stage", "sim:xy.json", "--session",
       "again"},
      {"session", "status", "my lab"},
      {"session", "resume", "my lab", "--session", "fit it"},
      {"session", "recover", "my lab"},
      {"campaign", "list"},
      {"campaign", "show", "my lab"},
      {"campaign", "check", "my lab"},
      {"campaign", "export", "my lab", "--out", "copy"},
      {"reading", "exclude", "my lab", "--seq", "3", "--reason", "a test"},
      {"calibrate", "geometry", "my lab"},
      {"session", "run", "my lab", "--plan", "far.json", "--stage", "sim:xy.json", "--session",
       "far", "--compensate", "1"},
      {"job", "list"},
      {"job", "show", "1"},
      {"job", "why", "1"},
      {"job", "verify", "1"},
      {"report", "my lab"},
      {"assess", "my lab"},
      {"diagnose", "my lab"},
      {"diagnose", "my lab", "--plan", "more.json"},
      {"plan", "create", "lattice", "--campaign", "my lab", "--step", "45", "--out", "in.json"},
      {"plan", "check", "in.json", "--campaign", "my lab"},
      {"model", "list", "my lab"},
      {"model", "show", "my lab", "last"},
      {"model", "predict", "my lab", "last", "--pose", "10,20"},
      {"model", "export", "my lab", "last", "--out", "table.csv", "--step-mm", "45"},
      {"query", "v_accuracy"},
      {"protocol", "check", "lost.json"},
      {"report", "no lab"},
      {"db", "check"},
      {"db", "verify"},
      {"db", "backup", "--out", "copy.db"},
      {"licenses"},
  };
}

/// What a person puts in the place of a word in capitals.
std::string answered(std::string line) {
  const std::map<std::string, std::string> answers = {
      {"CAMPAIGN", "another"}, {"STAGE", "sim:xy.json"}, {"FILE", "xy.json"}, {"VERSION", "last"}};
  if (const std::size_t at = line.find("--out FILE"); at != std::string::npos) {
    line.replace(at + 6, 4, "new.db");
  }
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    const bool capitals =
        std::ranges::all_of(word, [](unsigned char c) { return std::isupper(c) != 0; });
    if (!capitals) continue;
    REQUIRE(answers.count(word) == 1);
    line.replace(line.find(word), word.size(), answers.at(word));
  }
  return line;
}

std::string next_line(const Finished& done) {
  const std::size_t at = done.err.find("next: ");
  if (at == std::string::npos) return "";
  const std::string line = done.err.substr(at + 6, done.err.find('\n', at) - at - 6);
  const std::size_t then = line.find("then: ");
  return then == std::string::npos ? line : line.substr(then + 6);
}

/// The value of an option on a line, as a shell would print it; empty: it is not there.
std::string value_of(const Words& words, const std::string& option) {
  const auto at = std::ranges::find(words, option);
  return at == words.end() || at + 1 == words.end() ? "" : *(at + 1);
}

}  // namespace

TEST_CASE("every next line can be typed, and is about the same machine, database and campaign",
          "[cli]") {
  const tests::TemporaryFolder folder;
  std::filesystem::copy(kXy, folder.path() / "xy.json");
  std::filesystem::copy(kUvw, folder.path() / "uvw.json");
  folder.write("lost.json", R"({"format": "protocol/1", "name": "a", "stage": "sim:lost robot.json",
    "steps": [{"name": "fit", "kind": "measure", "plan": "paper-80"}]})");
  folder.write("far.json", R"({"schema": "trammel/plan/1", "name": "far", "points": [
    {"seq": 1, "x_mm": 0, "y_mm": 0}, {"seq": 2, "x_mm": 400, "y_mm": 0}]})");
  int n = 0;
  for (Words words : lines()) {
    CAPTURE(words);
    words.insert(words.end(), {"--db", "my db.db"});
    const Finished done = run_here(words, folder.path());
    REQUIRE(done.exit_code != kUsage);
    const std::string next = next_line(done);
    CAPTURE(done.err, next);
    REQUIRE_THAT(next, StartsWith("trammel "));
    CHECK_THAT(next, Contains(" --db 'my db.db'") || Contains("trammel db verify --db copy.db"));
    const std::string stage = value_of(words, "--stage");
    std::string machine = stage.empty() ? value_of(words, "--mechanism") : stage.substr(4);
    if (words[0] == "mechanism") machine = words[2];
    const bool of_a_plan =
        next.starts_with("trammel plan check") || next.starts_with("trammel plan create");
    if (of_a_plan && !machine.empty()) CHECK_THAT(next, Contains(" --mechanism " + machine));
    const bool has_campaign = std::ranges::count(words, "my lab") > 0;
    if (has_campaign && !of_a_plan && next.find("trammel job ") == std::string::npos) {
      CHECK_THAT(next, Contains("'my lab'") || Contains(" copy "));
    }
    CHECK((!has_campaign || next.find("CAMPAIGN") == std::string::npos));
    const Finished after = tests::run_command(
        {"sh", "-c",
         tests::build_folder() + "/trammel" + answered(next).substr(7) + " --overwrite"},
        folder.path());
    CAPTURE(after.err, after.out);
    CHECK(after.exit_code != kUsage);
    CHECK((after.exit_code == 0 || after.exit_code == kNotAcceptable ||
           after.exit_code == done.exit_code));
    ++n;
  }
  CHECK(n > 40);
}
