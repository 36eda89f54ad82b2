// Completion: what the program offers, and what real shells make of it.

#include <algorithm>

#include "app/cli/cli.hpp"
#include "app/cli/command_tree.hpp"
#include "app/cli/commands.hpp"
#include "app/cli/complete.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/temporary.hpp"

using Catch::Matchers::StartsWith;
using namespace trammel;
using namespace trammel::cli;
using tests::Finished;
using tests::run_command;

namespace {

using Strings = std::vector<std::string>;

/// The program's tree of commands, and what the line was asked for.
struct Program {
  Context context;
  CommandLine app;
  std::string asked;
  Given given;

  Program() { set_up(app, context, commands()); }

  Strings offered(const Strings& words) {
    asked.clear();
    const Candidates found = candidates(app, words, [this](const auto& name, const auto& so_far) {
      asked = name;
      given = so_far;
      return Candidates{};
    });
    Strings all;
    for (const Candidate& candidate : found.words) all.push_back(candidate.word);
    return all;
  }
};

bool has(const Strings& all, const std::string& word) {
  return std::find(all.begin(), all.end(), word) != all.end();
}

/// Every command is offered behind its noun, and every option behind its command.
void check_offered(Program& program, Command command, const Strings& path) {
  for (const Command verb : visible_commands(command)) {
    Strings words = path;
    words.emplace_back("");
    CHECK(has(program.offered(words), verb.name()));
    words.back() = verb.name();
    check_offered(program, verb, words);
  }
  Strings words = path;
  words.emplace_back("--");
  CAPTURE(path);
  for (const Option option : options_of(command)) {
    CHECK(has(program.offered(words), "--" + option.long_names().front()));
  }
}

/// A folder with an imported campaign of an awkward name, and the scripts as the program prints
/// them.
class Desk {
 public:
  Desk() {
    const auto run = [this](Strings words) {
      words.insert(words.end(), {"--db", database()});
      const Finished done = tests::run_here(words);
      INFO(done.err);
      REQUIRE(done.exit_code == 0);
      return done.out;
    };
    run({"campaign", "import", tests::kDriveError});
    run({"campaign", "import", tests::kDriveError, "--name", "it's 2"});
    run({"calibrate", "lsq", "drive-error"});
    for (const char* shell : {"bash", "zsh", "fish"}) {
      folder_.write(std::string("trammel.") + shell, run({"completion", shell}));
    }
    folder_.write("robot.json", "{}");
    std::filesystem::create_directory(folder_.path() / "rooms");
  }

  /// Runs a shell that finds the built program first on its PATH; none when it is not installed.
  [[nodiscard]] std::optional<Finished> shell(const Strings& words) const {
    Strings line = {"env", "PATH=" + tests::build_folder() + ":/usr/bin:/bin",
                    "HOME=" + folder_.path().string()};
    line.insert(line.end(), words.begin(), words.end());
    const Finished done = run_command(line, folder_.path());
    if (done.exit_code != 127) return done;
    tests::skip_without(words.front());
    return std::nullopt;
  }

  [[nodiscard]] std::string file(const char* name) const { return folder_.path() / name; }
  [[nodiscard]] std::string database() const { return file("trammel.db"); }

 private:
  tests::TemporaryFolder folder_;
};

const Desk& desk() {
  static const Desk made;
  return made;
}

}  // namespace

TEST_CASE("every command and every option of the program is completed", "[cli]") {
  Program program;
  check_offered(program, program.app, {});
  CHECK_FALSE(has(program.offered({"c"}), "complete"));  // for shells, not for people
  CHECK(program.offered({"rep"}) == Strings{"report"});
  CHECK(program.offered({"xyz"}).empty());
  CHECK(program.offered({"report", "paper", "--js"}) == Strings{"--json"});
  CHECK(program.offered({"report", "--json", "paper", "--js"}).empty());  // given already
}

TEST_CASE("the words of a choice are completed, and behind = too", "[cli]") {
  Program program;
  CHECK(program.offered({"plan", "create", "lattice", "--order", ""}) ==
        Strings{"listed", "random", "nearest"});
  CHECK(program.offered({"plan", "create", "lattice", "--order=n"}) == Strings{"--order=nearest"});
  CHECK(has(program.offered({"plan", "create", "pap"}), "paper-80"));
  CHECK(program.offered({"completion", ""}) == Strings{"bash", "zsh", "fish"});
}

TEST_CASE("the value that stands at the cursor is asked for by its name", "[cli]") {
  Program program;
  const auto asked = [&program](const Strings& words) {
    program.offered(words);
    return program.asked;
  };
  CHECK(asked({"report", ""}) == "CAMPAIGN");
  CHECK(asked({"report", "paper", ""}).empty());  // nothing more to say
  CHECK(asked({"campaign", "import", ""}) == "FOLDER");
  CHECK(asked({"session", "run", "lab", "--stage", ""}) == "STAGE");
  CHECK(asked({"session", "run", "--plan", "p.json", "lab", "--compensate", ""}) == "JOB");
  CHECK(asked({"--db", ""}) == "FILE");
  CHECK(asked({"--db", "lab.db", "model", "show", "paper", ""}) == "VERSION");
  CHECK(program.given.at("CAMPAIGN") == "paper");
  CHECK(program.given.at("--db") == "lab.db");
  CHECK(asked({"plan", "create", "circle", "--centre", "-2", ""}) == "NUMBER");
}

TEST_CASE("campaigns, sessions and jobs are completed from the database of the line", "[cli]") {
  const auto complete = [](Strings words) {
    words.insert(words.begin(), {"complete", "--db", desk().database(), "--"});
    return tests::run_here(words).out;
  };
  CHECK(complete({"report", "dr"}) == "drive-error\tsimulated, 152 readings\n:none\n");
  CHECK_THAT(complete({"compare", "drive-error", ""}), Contains("it's 2\t"));
  CHECK_THAT(complete({"job", "show", ""}), Contains("1\tlsq of drive-error"));
  CHECK_THAT(complete({"query", "v_acc"}), Contains("v_accuracy\t"));
  CHECK(complete({"report", "--db", desk().file("nowhere.db"), ""}) == ":none\n");
  CHECK(complete({"report", "--db", desk().file("robot.json"), ""}) == ":none\n");  // no database
  CHECK_THAT(complete({"--db", ""}), Contains(":files"));
  CHECK_THAT(complete({"campaign", "import", ""}), Contains(":folders"));
}

TEST_CASE("bash completes commands, options, campaigns, choices and files", "[cli][release]") {
  // As bash calls it: the words of the line, broken at = and :, and the cursor in the last.
  const auto bash = [](const std::string& words) {
    const auto done = desk().shell({"bash", "--norc", "-c",
                                    "source ./trammel.bash; COMP_WORDS=(" + words +
                                        "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _trammel; "
                                        "printf '%s\\n' \"${COMPREPLY[@]}\""});
    REQUIRE(done.has_value());
    CHECK(done->exit_code == 0);
    CHECK(done->err.empty());
    return done->out;
  };
  CHECK(bash("trammel camp") == "campaign\n");
  CHECK(bash("trammel report ''") == "drive-error\nit\\'s\\ 2\n");
  CHECK(bash("trammel report drive-error --js") == "--json\n");
  CHECK(bash("trammel plan create lattice --order = ne") == "nearest\n");
  CHECK(bash("trammel mechanism check rob") == "robot.json\n");
  CHECK(bash("trammel session run lab --stage sim : rob") == "robot.json\n");
  CHECK(bash("trammel campaign import roo") == "rooms\n");
}

TEST_CASE("fish completes commands, options, campaigns, choices and files", "[cli][release]") {
  const auto fish = [](const std::string& line) -> std::optional<std::string> {
    const auto done = desk().shell(
        {"fish", "--no-config", "-c", "source ./trammel.fish; complete -C \"" + line + "\""});
    if (!done) return std::nullopt;
    CHECK(done->exit_code == 0);
    CHECK(done->err.empty());
    return done->out;
  };
  const auto commands = fish("trammel camp");
  if (!commands) return;
  CHECK_THAT(*commands, StartsWith("campaign\tCampaigns: "));
  CHECK_THAT(*fish("trammel report "), StartsWith("drive-error\tsimulated"));
  CHECK_THAT(*fish("trammel report drive-error --js"), StartsWith("--json\t"));
  CHECK_THAT(*fish("trammel plan create lattice --order ne"), StartsWith("nearest"));
  CHECK_THAT(*fish("trammel mechanism check rob"), StartsWith("robot.json"));
  CHECK_THAT(*fish("trammel session run lab --stage sim:rob"), StartsWith("sim:robot.json"));
  CHECK_THAT(*fish("trammel campaign import roo"), StartsWith("rooms/"));
}

TEST_CASE("zsh completes commands, options, campaigns, choices and files", "[cli][release]") {
  const auto done = desk().shell(
      {"zsh", "-f", tests::source_folder() + "/tests/app/cli/keys.zsh", "trammel camp",
       "trammel report dr", "trammel report it", "trammel plan create lattice --order ne",
       "trammel plan create lattice --order=ne", "trammel mechanism check rob",
       "trammel session run lab --stage sim:rob", "trammel campaign import roo"});
  if (!done) return;
  CHECK(done->exit_code == 0);
  CHECK(done->out ==
        "trammel campaign \n"
        "trammel report drive-error \n"
        "trammel report it\\'s\\ 2 \n"
        "trammel plan create lattice --order nearest \n"
        "trammel plan create lattice --order=nearest \n"
        "trammel mechanism check robot.json \n"
        "trammel session run lab --stage sim:robot.json \n"
        "trammel campaign import rooms/\n");
}
