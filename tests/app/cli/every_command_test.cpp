// Walks the command tree of the built program: a command that is added is tested by being there.
// The cases share one laboratory and run in this order; what changes it comes behind what must not.

#include <signal.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/cli/cli.hpp"
#include "app/cli/commands.hpp"
#include "app/session/lock.hpp"
#include "app/terminal/columns.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::Finished;
using tests::kDriveError;
using tests::run_here;
using tests::run_program;

namespace {

using Words = std::vector<std::string>;

const std::string kTrackerFiles = tests::source_folder() + "/examples/tracker-files/";

struct CommandWords {
  Words words;                       // {"campaign", "import"}
  std::vector<std::string> options;  // "--dry-run", …: its own and those all commands share
  [[nodiscard]] std::string name() const {
    return words.size() == 1 ? words[0] : words[0] + " " + words[1];
  }
  [[nodiscard]] bool has(const std::string& option) const {
    return std::find(options.begin(), options.end(), option) != options.end();
  }
};

std::vector<CommandWords> all_commands() {
  cli::Context context;
  cli::CommandLine app;
  cli::set_up(app, context, cli::commands());
  std::vector<CommandWords> found;
  const auto add = [&found](cli::Command leaf, Words words) {
    CommandWords command{std::move(words), {}};
    for (const cli::Option option : leaf.options()) {
      for (const std::string& name : option.long_names()) command.options.push_back("--" + name);
    }
    found.push_back(std::move(command));
  };
  for (const cli::Command noun : app.commands()) {
    if (noun.name() == "archive") continue;  // another program: archive_program_test.cpp
    const auto verbs = noun.commands();
    if (verbs.empty()) add(noun, {noun.name()});
    for (const cli::Command verb : verbs) add(verb, {noun.name(), verb.name()});
  }
  return found;
}

/// What each command is given in the prepared laboratory. A new command needs a line here.
const std::map<std::string, Words>& examples() {
  static const std::map<std::string, Words> all = {
      {"demo", {"demo"}},
      {"template", {"stage", "galil"}},
      {"protocol run", {"demo/protocol.json"}},
      {"protocol check", {"demo/protocol.json"}},
      {"plan create", {"lattice", "--step", "50", "--out", "made.json"}},
      {"plan show", {"plan.json"}},
      {"plan check", {"plan.json", "--identifiability"}},
      {"session run", {"lab", "--plan", "plan.json", "--stage", "sim:demo/robot.json"}},
      {"session resume", {"paper", "--session", "measure-80"}},
      {"session status", {"paper"}},
      {"session pause", {"drive-error", "--dry-run"}},
      {"session stop", {"drive-error", "--dry-run"}},
      {"session recover", {"paper"}},
      {"campaign list", {}},
      {"campaign show", {"paper"}},
      {"campaign check", {"paper"}},
      {"campaign import", {kDriveError, "--name", "again"}},
      {"campaign points", {kTrackerFiles + "spatialanalyzer.txt"}},
      {"campaign export", {"paper", "--out", "exported"}},
      {"reading exclude", {"drive-error", "--seq", "3", "--reason", "a test"}},
      {"calibrate lsq", {"drive-error"}},
      {"calibrate geometry", {"drive-error"}},
      {"calibrate idw", {"drive-error"}},
      {"calibrate rbf", {"drive-error"}},
      {"calibrate gp", {"drive-error"}},
      {"calibrate hybrid", {"drive-error"}},
      {"calibrate contest", {"drive-error", "--blocks", "2"}},
      {"diagnose", {"--from", kDriveError, "--replicates", "500"}},
      {"model list", {"drive-error"}},
      {"model show", {"drive-error", "last"}},
      {"model diff", {"drive-error", "1", "last"}},
      {"model predict", {"drive-error", "last", "--pose", "10,20,0"}},
      {"model export", {"drive-error", "last", "--out", "table.csv", "--step-mm", "50"}},
      {"job list", {}},
      {"job show", {"1"}},
      {"job why", {"1"}},
      {"job verify", {"1"}},
      {"job diff", {"1", "2"}},
      {"job rerun", {"1"}},
      {"report", {"paper"}},
      {"serve", {"paper"}},
      {"assess", {"paper"}},
      {"compare", {"paper", "drive-error"}},
      {"mechanism check", {"demo/robot.json"}},
      {"mechanism ik", {"demo/robot.json", "--pose", "1", "2", "3"}},
      {"mechanism fk", {"demo/robot.json", "--l", "260", "261", "262"}},
      {"mechanism sensitivity", {"demo/robot.json"}},
      {"mechanism workspace", {"demo/robot.json", "--step", "50"}},
      {"emulate galil", {"--robot", "demo/robot.json", "--tracker-port", "0"}},
      {"emulate tracker", {"--robot", "demo/robot.json"}},
      {"query", {"SELECT * FROM v_accuracy"}},
      {"licenses", {}},
      {"db check", {}},
      {"db verify", {}},
      {"db backup", {"--out", "copy.db"}},
      {"db migrate", {}},
      {"completion", {"zsh"}},
      {"complete", {"--", "report", ""}},
      {"man", {}},
  };
  return all;
}

/// A laboratory that has measured, imported and diagnosed; made once for all tests.
class Laboratory {
 public:
  Laboratory() {
    prepare({"demo", "demo"});
    prepare({"campaign", "import", kDriveError});
    prepare({"diagnose", "drive-error", "--replicates", "500"});
    prepare({"plan", "create", "lattice", "--step", "100", "--out", "plan.json"});
  }

  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

  [[nodiscard]] Finished run(Words words, const Words& more = {}) const {
    return run_program(with_db(std::move(words), more), path());
  }

  /// Behind the command: what stands behind "--" is no option.
  static Words with_db(Words words, const Words& more = {}) {
    Words options = more;
    options.insert(options.end(), {"--db", "demo/trammel.db"});
    words.insert(std::find(words.begin(), words.end(), "--"), options.begin(), options.end());
    return words;
  }

  /// The same for a command that serves until it is stopped: stopped once it says where.
  [[nodiscard]] Finished serve(const Words& words) const {
    tests::Served served(with_db(words), path());
    static_cast<void>(served.first_line());
    return served.stop(SIGTERM);
  }

  /// Every file with its content; what SQLite and the lock keep beside a database is not data.
  [[nodiscard]] std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path())) {
      const std::string name = entry.path().string();
      const bool beside = name.ends_with("-wal") || name.ends_with("-shm") ||
                          name.find(".lock") != std::string::npos;
      if (entry.is_regular_file() && !beside) all[name] = tests::read_text(entry.path());
    }
    return all;
  }

 private:
  void prepare(const Words& words) const {
    const Finished done = run(words);
    INFO(done.err);
    REQUIRE(done.exit_code == 0);
  }

  tests::TemporaryFolder folder_;
};

const Laboratory& laboratory() {
  static const Laboratory made;
  return made;
}

Words line(const CommandWords& command, const Words& more = {}) {
  Words words = command.words;
  const auto example = examples().find(command.name());
  if (example == examples().end()) {
    throw std::runtime_error("no example for `" + command.name() + "`: add one to this test");
  }
  words.insert(words.end(), example->second.begin(), example->second.end());
  words.insert(std::find(words.begin(), words.end(), "--"), more.begin(), more.end());
  return words;
}

/// Commands that serve until they are stopped.
bool serves(const CommandWords& command) {
  return command.words[0] == "emulate" || command.words[0] == "serve";
}

Finished run(const CommandWords& command, const Words& words) {
  return serves(command) ? laboratory().serve(words) : laboratory().run(words);
}

/// "trammel/campaign-import/1"; the stages of calibrate share one.
std::string schema_of(const CommandWords& command) {
  if (command.words[0] == "calibrate") return "trammel/calibrate/1";
  return "trammel/" + command.words[0] +
         (command.words.size() > 1 ? "-" + command.words[1] : std::string()) + "/1";
}

std::string file_of(const std::string& schema) {
  const std::size_t from = schema.find('/') + 1;
  return schema.substr(from, schema.rfind('/') - from) + ".schema.json";
}

void check_answer(const std::string& schema, const std::string& out) {
  REQUIRE(nlohmann::ordered_json::accept(out));
  const auto answer = nlohmann::ordered_json::parse(out);
  REQUIRE(answer.is_object());
  REQUIRE_FALSE(answer.empty());
  CHECK(answer.begin().key() == "schema");
  CHECK(answer.at("schema") == schema);
  CHECK(tests::schema_errors(nlohmann::json::parse(out), file_of(schema)) == "");
}

/// Words of a text, without what makes some bold.
Words printed_words(std::string text) {
  for (const std::string bold : {"\x1b[1m", "\x1b[0m", "\r"}) {
    for (auto at = text.find(bold); at != std::string::npos; at = text.find(bold)) {
      text.erase(at, bold.size());
    }
  }
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

std::size_t columns_without_bold(const std::string& line) {
  const std::size_t n = terminal::columns_of(line);
  return line.ends_with('\r') ? n - 1 : n;
}

/// The process of this test measures drive-error, as far as others can see.
class Measuring {
 public:
  Measuring() : lock_(file(), uuid()) {}

 private:
  static std::filesystem::path file() { return laboratory().path() / "demo/trammel.db"; }
  static std::string uuid() {
    store::Connection db = store::open(file(), store::Access::read_only);
    return store::require_campaign(db, "drive-error").uuid;
  }
  session::CampaignLock lock_;
};

}  // namespace

TEST_CASE("every command explains itself with its exit codes and every value, in 100 columns",
          "[cli][release]") {
  for (const CommandWords& command : all_commands()) {
    CAPTURE(command.name());
    Words words = command.words;
    words.emplace_back("--help");
    const Finished help = run_here(words);
    CAPTURE(help.out);
    CHECK(help.exit_code == 0);
    CHECK(help.err.empty());
    CHECK_THAT(help.out, Contains("Exit codes:") && Contains("130  interrupted"));
    std::istringstream in(help.out);
    for (std::string line; std::getline(in, line);) {
      CHECK(terminal::columns_of(line) <= 100);
      if (line.starts_with("  --")) CHECK(line.substr(0, 30).find(" TEXT") == std::string::npos);
    }
  }
}

TEST_CASE("a command that is set up alone is the one that its row names", "[cli]") {
  for (const cli::ProgramCommand& row : cli::commands()) {
    if (row.name == nullptr) continue;
    cli::Context context;
    cli::CommandLine app;
    cli::set_up(app, context, {row});
    const auto made = app.commands();
    REQUIRE(made.size() == 1);
    CHECK(made[0].name() == row.name);
  }
}

TEST_CASE("every command answers a misspelt option with 2 and the right one", "[cli]") {
  for (const CommandWords& command : all_commands()) {
    for (std::string option : {command.options.back(), std::string("--json")}) {
      if (option == "--help") continue;
      CAPTURE(command.name(), option);
      const std::string meant = option;
      option.insert(std::min<std::size_t>(4, option.size()), "x");
      Words words = command.words;
      words.push_back(option);
      const Finished answer = run_here(words);
      CHECK(answer.exit_code == 2);
      CHECK(answer.out.empty());
      CHECK_THAT(answer.err, Contains("did you mean") && Contains(meant));
    }
  }
}

TEST_CASE("every command that can change anything has --dry-run, which changes nothing",
          "[cli][release]") {
  const Measuring measuring;
  const auto before = laboratory().files();
  for (const CommandWords& command : all_commands()) {
    CAPTURE(command.name());
    const Words more = command.has("--dry-run") ? Words{"--dry-run"} : Words{};
    Words words = line(command);
    if (std::find(words.begin(), words.end(), "--dry-run") == words.end())
      words = line(command, more);
    const Finished done = run(command, words);
    INFO(done.err);
    CHECK(done.exit_code == 0);
    CHECK(laboratory().files() == before);
    CHECK(done.out.find('\x1b') == std::string::npos);
    CHECK(done.err.find('\x1b') == std::string::npos);
    // What to do next, once.
    const auto next = done.err.find("next: ");
    CHECK((next != std::string::npos || command.name() == "complete"));  // that one is for shells
    CHECK(done.err.find("next: ", next + 1) == std::string::npos);
    // Data alone, also of what would be done; what has no --dry-run answers in the next case.
    if (std::find(words.begin(), words.end(), "--dry-run") == words.end()) continue;
    words.insert(std::find(words.begin(), words.end(), "--"), "--json");
    const Finished json = run(command, words);
    CHECK(json.err.find("next: ") == std::string::npos);
    check_answer(schema_of(command), json.out);
  }
}

TEST_CASE("with --json every command prints one object, valid against its schema", "[cli]") {
  const Measuring measuring;
  for (const CommandWords& command : all_commands()) {
    CAPTURE(command.name());
    const Finished done = run(command, line(command, {"--json"}));
    INFO(done.err);
    CHECK(done.exit_code == 0);
    CHECK(done.out.find('\x1b') == std::string::npos);
    check_answer(schema_of(command), done.out);
    CHECK(done.err.find("next:") == std::string::npos);
  }
}

TEST_CASE("answers of another form, and those that are not acceptable, are valid too", "[cli]") {
  struct Other {
    Words words;
    const char* schema;
    int exit_code;
  };
  const Laboratory& lab = laboratory();
  REQUIRE(lab.run({"plan", "create", "circle", "--radius", "400", "--out", "far.json"}).exit_code ==
          0);
  for (const Other& other : std::vector<Other>{
           {{"job", "rerun", "--all", "--stage", "lsq"}, "job-rerun-all", 0},
           {{"plan", "create", "circle"}, "plan", 0},
           {{"plan", "create", "optimal", "--points", "12", "--out", "o.json"}, "plan-create", 0},
           {{"plan", "check", "far.json"}, "plan-check", 5},
           {{"session", "run", "lab", "--plan", "far.json", "--stage", "sim:demo/robot.json"},
            "session-run",
            6},
           {{"diagnose", "drive-error", "--require", "unexplained"}, "diagnose", 5},
           {{"calibrate", "geometry", "drive-error", "--effects", "lead_scale"}, "calibrate", 0},
           {{"model", "export", "drive-error", "last", "--out", "model.json"}, "model-export", 0},
           {{"model", "export", "drive-error", "--format", "linuxcnc", "--out", "cnc"},
            "model-export",
            0},
           {{"model", "export", "drive-error", "--format", "aerotech", "--out", "a.cal"},
            "model-export",
            0},
           {{"model", "predict", "drive-error", "last", "--commands",
             kDriveError + "/readings.csv"},
            "model-predict",
            0},
           {{"mechanism", "ik", "demo/robot.json", "--pose", "600", "0", "0"}, "mechanism-ik", 5},
           {{"mechanism", "ik", "demo/robot.json", "--plan", "paper-48", "--jacobians"},
            "mechanism-ik",
            0},
           {{"mechanism", "fk", "demo/robot.json", "--l", "9", "9", "999"}, "mechanism-fk", 5},
           {{"assess", "drive-error"}, "assess", 0},
           {{"complete", "--", "campaign", ""}, "complete", 0}}) {
    CAPTURE(other.words);
    const Finished done = lab.run(other.words, {"--json"});
    INFO(done.err);
    CHECK(done.exit_code == other.exit_code);
    check_answer(std::string("trammel/") + other.schema + "/1", done.out);
  }
}

TEST_CASE("every error says what to do next", "[cli]") {
  const tests::TemporaryFolder empty;
  int n_failed = 0;
  for (const CommandWords& command : all_commands()) {
    CAPTURE(command.name());
    const Words more = command.has("--dry-run") ? Words{"--dry-run"} : Words{};
    const Finished failed = run_here(line(command, more), empty.path());
    if (failed.exit_code == 0) continue;  // needs no file and no database
    ++n_failed;
    CAPTURE(failed.err);
    const bool hint = failed.err.find("; ") != std::string::npos;
    CHECK((hint || failed.err.find("next: ") != std::string::npos));
    Words json = more;
    json.emplace_back("--json");
    const Finished again = run_here(line(command, json), empty.path());
    CHECK(nlohmann::json::parse(again.err).at("hint").get<std::string>().size() > 5);
  }
  CHECK(n_failed > 30);
}

TEST_CASE("files of the program's own formats are valid against their schemas", "[cli][release]") {
  const std::filesystem::path examples = tests::source_folder() + "/examples";
  const Laboratory& lab = laboratory();
  REQUIRE(lab.run({"model", "export", "drive-error", "last", "--out", "m.json"}).exit_code == 0);
  REQUIRE(lab.run({"campaign", "export", "paper", "--out", "as-files"}).exit_code == 0);
  struct File {
    std::filesystem::path path;
    const char* schema;
  };
  for (const File& file :
       std::vector<File>{{examples / "paper/robot.json", "robot.schema.json"},
                         {examples / "paper/protocol.json", "protocol.schema.json"},
                         {examples / "tracker-files/plan.json", "plan.schema.json"},
                         {lab.path() / "plan.json", "plan.schema.json"},
                         {lab.path() / "m.json", "model.schema.json"},
                         {lab.path() / "as-files/campaign.json", "campaign.schema.json"},
                         {kDriveError + "/campaign.json", "campaign.schema.json"}}) {
    CAPTURE(file.path);
    CHECK(tests::schema_errors(nlohmann::json::parse(tests::read_text(file.path)), file.schema) ==
          "");
  }
  const auto report = nlohmann::json::parse(tests::read_text(lab.path() / "demo/report.json"));
  CHECK(tests::schema_errors(report, "report.schema.json") == "");
}

TEST_CASE("errors are valid against their schema, and a wrong object is not", "[cli]") {
  const tests::TemporaryFolder folder;
  const auto with_db = [&folder](Words words) {
    words.insert(words.end(), {"--db", folder.path() / "trammel.db"});
    return words;
  };
  REQUIRE(run_here(with_db({"campaign", "import", kDriveError})).exit_code == 0);
  for (const Words& words : std::vector<Words>{{"reprot", "--json"},
                                               {"report", "nobody", "--json"},
                                               {"campaign", "import", "nowhere", "--json"},
                                               {"model", "show", "drive-error", "9", "--json"}}) {
    CAPTURE(words);
    const Finished failed = run_here(with_db(words));
    CHECK(failed.out.empty());
    const auto error = nlohmann::json::parse(failed.err);
    CHECK(tests::schema_errors(error, "error.schema.json") == "");
    CHECK(error.at("exit_code") == failed.exit_code);
  }
  CHECK(tests::schema_errors({{"schema", "trammel/error/1"}}, "error.schema.json") != "");
  CHECK(tests::schema_errors({{"schema", "trammel/db-check/1"}, {"extra", 1}},
                             "db-check.schema.json") != "");
}

TEST_CASE("a terminal gets bold headings, and none where NO_COLOR is set", "[cli][release]") {
  const tests::TemporaryFolder folder;
  REQUIRE(run_program({"campaign", "import", kDriveError}, folder.path()).exit_code == 0);
  REQUIRE(run_program({"calibrate", "lsq", "drive-error"}, folder.path()).exit_code == 0);
  const Words words = {"report", "drive-error", "--db", "trammel.db"};
  const std::string bold = tests::run_on_terminal(words, folder.path(), false);
  const std::string plain = tests::run_on_terminal(words, folder.path(), true);
  CHECK(bold.find("\x1b[1m") != std::string::npos);
  CHECK(plain.find('\x1b') == std::string::npos);
  CHECK(plain.size() > 1000);
}

TEST_CASE("on a narrow terminal no line is too long and no number is cut", "[cli][release]") {
  constexpr int kColumns = 72;
  for (const Words& words : std::vector<Words>{{"report", "paper"},
                                               {"assess", "paper"},
                                               {"compare", "paper", "drive-error"},
                                               {"plan", "show", "paper-48"},
                                               {"mechanism", "sensitivity", "demo/robot.json"}}) {
    CAPTURE(words);
    const Words with_db = Laboratory::with_db(words, {"--quiet"});
    const std::string narrow =
        tests::run_on_terminal(with_db, laboratory().path(), false, kColumns);
    const Words whole = printed_words(run_program(with_db, laboratory().path()).out);
    for (const std::string& word : printed_words(narrow)) {
      CAPTURE(word);
      const bool drawn = std::ranges::none_of(  // a rule or a bar is as long as there is room
          word, [](unsigned char c) { return std::isalnum(c) != 0; });
      CHECK((drawn || std::find(whole.begin(), whole.end(), word) != whole.end()));
    }
    std::istringstream in(narrow);
    for (std::string line; std::getline(in, line);) {
      CAPTURE(line);
      CHECK((columns_without_bold(line) <= kColumns || printed_words(line).size() == 1));
    }
  }
  for (const Words& words :
       std::vector<Words>{{"campaign", "list"}, {"job", "list"}, {"session", "status", "paper"}}) {
    CAPTURE(words);
    const Words with_db = Laboratory::with_db(words, {"--quiet"});
    std::istringstream in(tests::run_on_terminal(with_db, laboratory().path(), false, kColumns));
    for (std::string line; std::getline(in, line);) CHECK(columns_without_bold(line) <= kColumns);
  }
}

TEST_CASE("a progress bar is drawn on a terminal alone", "[cli][release]") {
  const tests::TemporaryFolder folder;
  const std::string robot = "sim:" + tests::source_folder() + "/examples/paper/robot.json";
  const Words words = {"session", "run", "lab", "--plan", "paper-48", "--stage", robot};
  const Finished piped = run_program(words, folder.path());
  REQUIRE(piped.exit_code == 0);
  CHECK(piped.err.find('\r') == std::string::npos);
  const tests::TemporaryFolder other;
  CHECK_THAT(tests::run_on_terminal(words, other.path(), false), Contains("\r[####"));
}
