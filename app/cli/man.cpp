#include "app/cli/man.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/cli.hpp"
#include "app/cli/command_tree.hpp"
#include "store/provenance.hpp"

namespace trammel::cli {

namespace {

/// The code point that begins at `at` of UTF-8 text; `at` moves behind it.
unsigned code_point(const std::string& text, std::size_t& at) {
  const auto byte = static_cast<unsigned char>(text[at++]);
  const unsigned more = byte >= 0xF0 ? 3 : byte >= 0xE0 ? 2 : byte >= 0xC0 ? 1 : 0;
  unsigned point = more == 0 ? byte : byte & (0x3FU >> more);
  for (unsigned k = 0; k < more && at < text.size(); ++k) {
    point = (point << 6U) | (static_cast<unsigned char>(text[at++]) & 0x3FU);
  }
  return point;
}

/// Text that stands as it is on the page, with the backslash, dashes and letters beyond ASCII told
/// as groff wants them; a line that begins like a request does not become one.
std::string roff(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const bool line_begins = at == 0 || text[at - 1] == '\n';
    const unsigned point = code_point(text, at);
    if (line_begins && (point == '.' || point == '\'')) out += "\\&";
    if (point == '\\') {
      out += "\\e";
    } else if (point == '-') {
      out += "\\-";
    } else if (point >= 0x80) {
      out += fmt::format("\\[u{:04X}]", point);
    } else {
      out += static_cast<char>(point);
    }
  }
  return out;
}

std::string bold_roff(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string value_roff(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string more_of(Option option) { return option.takes_many() ? " ..." : ""; }

std::string option_entry(Option option) {
  std::string head;
  if (option.is_positional()) {
    head = value_roff(value_name(option));
  } else {
    head = bold_roff(option.all_names());
    const int n = std::max(1, option.expected_min());
    for (int k = 0; k < n && !value_name(option).empty(); ++k) {
      head += " " + value_roff(value_name(option));
    }
  }
  return ".TP\n" + head + more_of(option) + "\n" + roff(described(option)) + "\n";
}

std::string usage(Command command) {
  std::string line = bold_roff(full_name(command));
  for (const Option option : positionals_of(command)) {
    const std::string name = value_roff(value_name(option)) + more_of(option);
    line += option.is_required() ? " " + name : " [" + name + "]";
  }
  return line + " [" + value_roff("options") + "]";
}

void add_command(Command command, std::string& page) {
  const auto verbs = visible_commands(command);
  for (const Command verb : verbs) add_command(verb, page);
  if (!verbs.empty()) return;
  page += ".SS " + usage(command) + "\n" + roff(command.description()) + "\n";
  for (const Option option : positionals_of(command)) page += option_entry(option);
  for (const Option option : command.options()) {
    if (!option.is_positional() && option != command.help_option()) page += option_entry(option);
  }
}

struct Entry {
  const char* name;
  const char* what;
};
constexpr Entry kEnvironment[] = {
    {"TRAMMEL_DB", "The database file where no --db is given."},
    {"TRAMMEL_ARCHIVE", "The archive where a line of `trammel archive` names none."},
    {"NO_COLOR", "Set and not empty: no bold text on a terminal."},
    {"LC_ALL, LC_CTYPE, LANG", "Without UTF-8, pictures in reports are drawn with ASCII letters."},
};
constexpr Entry kExamples[] = {
    {"trammel demo", "The paper's whole campaign on a virtual robot, with its report."},
    {"trammel campaign import FOLDER",
     "Stores the readings of another tool (campaign/2, campaign/1)."},
    {"trammel calibrate lsq paper && trammel report paper", "Accuracy before and after."},
    {"trammel diagnose paper", "Which physical effect the model is missing."},
};

template <std::size_t N>
std::string entries(const Entry (&all)[N]) {
  std::string text;
  for (const Entry& entry : all) {
    text += ".TP\n" + bold_roff(entry.name) + "\n" + roff(entry.what) + "\n";
  }
  return text;
}

}  // namespace

std::string man_page(Command app) {
  std::string page =
      ".TH TRAMMEL 1 \"\" \"trammel " + store::this_program().tool_version +
      "\" \"Trammel\"\n.SH NAME\n" +
      roff("trammel - measurement campaigns on planar machines driven by linear axes") +
      "\n.SH SYNOPSIS\n" + bold_roff("trammel") + " " + value_roff("command") + " [" +
      value_roff("options") + "]\n.SH DESCRIPTION\n" + roff(app.description()) + "\n.PP\n" +
      roff(
          "stdout is data, stderr is talk. With --json a command prints one object with a schema "
          "field, for errors too. The schemas are in the folder schemas of the package.") +
      "\n.SH COMMON OPTIONS\n";
  for (const Option option : app.options()) page += option_entry(option);
  page += ".SH COMMANDS\n";
  for (const Command command : visible_commands(app)) add_command(command, page);
  page += ".SH EXIT STATUS\n";
  for (const ExitMeaning& row : exit_codes()) {
    page += fmt::format(".TP\n\\fB{}\\fR\n{}\n", static_cast<int>(row.code), roff(row.meaning));
  }
  return page + ".SH ENVIRONMENT\n" + entries(kEnvironment) + ".SH EXAMPLES\n" + entries(kExamples);
}

ExitCode run_man(const ManOptions& options, Context& context) {
  const std::string page = man_page(options.app);
  context.json ? context.print("man", {{"page", page}}) : context.print_as_is(page);
  return ExitCode::ok;
}

void setup_man(Command app, Context& context) {
  auto options = std::make_shared<ManOptions>(ManOptions{app});
  on_run(app.command("man", "This manual as a man page: trammel man | man -l -"), context, options,
         run_man);
}

}  // namespace trammel::cli
