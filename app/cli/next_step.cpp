#include "app/cli/next_step.hpp"

#include <algorithm>
#include <array>

#include "app/cli/command_tree.hpp"

namespace trammel::cli {

namespace {

/// In capitals: the value that the line gave by that name; THIS: the line as it is.
struct Row {
  const char* command;
  const char* after_ok;
  const char* after_failure;
};
constexpr auto kRows = std::to_array<Row>({
    // clang-format off
    {"plan create",           "THIS --out plan.json",                           ""},
    {"plan show",             "trammel plan check PLAN --mechanism FILE",       ""},
    {"plan check",            "trammel session run CAMPAIGN --plan PLAN --stage STAGE",
                              "trammel plan show PLAN"},
    {"session run",           "trammel session status CAMPAIGN",                "trammel plan check PLAN"},
    {"session resume",        "trammel report CAMPAIGN",                        "trammel session status CAMPAIGN"},
    {"emulate",               "trammel session run CAMPAIGN --plan PLAN --stage galil:stage.json --tracker "
                              "t2sa:tracker.json",                            ""},
    {"campaign check",        "trammel campaign show CAMPAIGN",                 "trammel diagnose CAMPAIGN"},
    {"campaign points",       "trammel campaign import --points FILE --layout layout.json", ""},
    {"campaign export",       "trammel campaign import FOLDER --dry-run",       ""},
    {"calibrate",             "trammel report CAMPAIGN",                        ""},
    {"diagnose",              "trammel report CAMPAIGN",                        "trammel report CAMPAIGN"},
    {"model diff",            "trammel model predict CAMPAIGN last --pose 0,0,0", ""},
    {"model predict",         "trammel model export CAMPAIGN VERSION --out compensation.csv",
                              "trammel model show CAMPAIGN VERSION"},
    {"model export",          "trammel model list CAMPAIGN",                    ""},
    {"job show",              "trammel job why JOB",                            ""},
    {"job why",               "trammel job verify JOB",                         ""},
    {"job verify",            "trammel job list",                               "trammel job why JOB"},
    {"job diff",              "trammel job why JOB",                            ""},
    {"job rerun",             "trammel job list",                               "trammel job list"},
    {"assess",                "trammel diagnose CAMPAIGN",                      ""},
    {"compare",               "trammel report CAMPAIGN",                        ""},
    {"mechanism check",       "trammel mechanism workspace FILE",               "trammel mechanism workspace FILE"},
    {"mechanism ik",          "trammel mechanism workspace FILE",               "trammel mechanism workspace FILE"},
    {"mechanism fk",          "trammel mechanism workspace FILE",               "trammel mechanism workspace FILE"},
    {"mechanism sensitivity", "trammel mechanism workspace FILE",               ""},
    {"serve",                 "trammel report CAMPAIGN",                        ""},
    {"query",                 "trammel query SQL --csv",                        ""},
    {"db check",              "trammel db verify",                              "restore a backup, then: trammel db verify"},
    {"db verify",             "trammel db backup --out FILE",                   "look at what is named; where rows were changed, restore a backup, then: trammel db verify"},
    {"db backup",             "trammel db verify --db FILE",                    ""},
    {"db migrate",            "trammel db verify",                              ""},
    {"licenses",              "trammel --version --json",                       ""},
    {"man",                   "trammel man | man -l -",                         ""},
    // clang-format on
});

/// The words of the command without "trammel", and of its noun alone.
const Row* row_of(Command command) {
  std::string name = full_name(command).substr(full_name(command).find(' ') + 1);
  const auto find = [&name] {
    return std::ranges::find_if(kRows, [&name](const Row& row) { return row.command == name; });
  };
  auto row = find();
  if (row == kRows.end()) {
    name = name.substr(0, name.find(' '));
    row = find();
  }
  return row == kRows.end() ? nullptr : &*row;
}

std::string joined(const std::vector<std::string>& words) {
  std::string line = "trammel";
  bool values_only = false;  // behind "--"
  for (const std::string& word : words) {
    const std::size_t name = std::min(word.find_first_not_of('-'), word.size());
    if (word == "--") {
      values_only = true;
    } else if (values_only || name == 0) {
      line += " " + shell_word(word);
    } else {
      line += " " + word.substr(0, name) + shell_word(word.substr(name));
    }
  }
  return line;
}

/// The row's line with the values of this one in the place of their names.
std::string filled(const std::string& line, Command command,
                   const std::vector<std::string>& words) {
  std::string out;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t end = std::min(line.find(' ', at), line.size());
    std::string word = line.substr(at, end - at);
    if (word == "THIS") word = joined(words);
    for (const Option option : command.options()) {
      const auto given = option.words();
      if (word != value_name(option) || given.empty()) continue;
      word = shell_word(given.front());
      break;
    }
    out += (out.empty() ? "" : " ") + word;
    at = end + 1;
  }
  return out;
}

}  // namespace

std::string named_machine(Command command) {
  const bool is_first = full_name(command).starts_with("trammel mechanism ");
  for (const Option option : command.options()) {
    const auto words = option.words();
    if (words.empty()) continue;
    const std::string& word = words.front();
    const auto& names = option.long_names();
    const auto named = [&names](const char* name) { return std::ranges::count(names, name) > 0; };
    if (named("mechanism") || (is_first && names.empty())) return word;
    if (named("stage")) return word.substr(word.find(':') + 1);
  }
  return "";
}

std::string first_calibration(const Machine& machine) {
  return machine.kind->chain == &kPrrChain ? "trammel calibrate lsq "
                                           : "trammel calibrate geometry ";
}

std::string next_step(Command app, const std::vector<std::string>& words, ExitCode code) {
  Command command = chosen_command(app);
  if (code == ExitCode::ok && std::ranges::find(words, "--dry-run") != words.end()) {
    std::vector<std::string> same = words;
    std::erase(same, "--dry-run");
    return joined(same);
  }
  const Row* row = row_of(command);
  if (row == nullptr) return "";
  return filled(code == ExitCode::ok ? row->after_ok : row->after_failure, command, words);
}

std::string next_step_after_error(Command app, const std::vector<std::string>& words, ExitCode code,
                                  Fault fault) {
  Command command = chosen_command(app);
  const std::string again = joined(words), help = full_name(command) + " --help";
  switch (code) {
    case ExitCode::not_found:
      if (fault == Fault::part) {
        const std::string show = filled("trammel campaign show CAMPAIGN", command, words);
        if (!show.ends_with(" CAMPAIGN")) return show;
      }
      if (fault == Fault::file_of_another) return "put that file there, then: " + again;
      return fault == Fault::stored ? "trammel campaign list" : help;
    case ExitCode::invalid_data:
      return fault == Fault::line ? help : "put the file right, then: " + again;
    case ExitCode::safety_stop:
      return "look at the machine, then: " + again;
    case ExitCode::device:
      return "see to power, cable and address, then: " + again;
    case ExitCode::storage:
      return "trammel db check";
    default:
      return help;
  }
}

}  // namespace trammel::cli
