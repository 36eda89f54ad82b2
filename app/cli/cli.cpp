#include "app/cli/cli.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/cli/command_tree.hpp"
#include "app/cli/licenses.hpp"
#include "app/cli/next_step.hpp"
#include "app/cli/sink.hpp"
#include "app/cli/suggest.hpp"
#include "app/files/format.hpp"
#include "app/files/numbers.hpp"
#include "app/terminal/columns.hpp"
#include "store/provenance.hpp"

namespace trammel::cli {

namespace {

constexpr std::array<ExitMeaning, 10> kCodes = {{
    {ExitCode::ok, "ok", "ok"},
    {ExitCode::error, "error", "error"},
    {ExitCode::usage, "usage", "the command line is wrong"},
    {ExitCode::not_found, "not_found", "not found (a file, a campaign, a job)"},
    {ExitCode::invalid_data, "invalid_data",
     "invalid data (the message names file, line and field)"},
    {ExitCode::not_acceptable, "not_acceptable",
     "it ran, and the answer is not acceptable (a gate)"},
    {ExitCode::safety_stop, "safety_stop", "safety stop: nothing moves"},
    {ExitCode::device, "device", "device or link"},
    {ExitCode::storage, "storage", "storage (the database)"},
    {ExitCode::interrupted, "interrupted", "interrupted"},
}};

const char* kind_of(ExitCode code) {
  const auto* at = std::find_if(kCodes.begin(), kCodes.end(),
                                [code](const ExitMeaning& row) { return row.code == code; });
  return at == kCodes.end() ? "error" : at->kind;
}

constexpr std::size_t kShownColumnsOfGot = 100;  // of one word that came; --json has it whole

/// Only the parts that apply.
Json error_json(ExitCode code, const ErrorText& text) {
  Json object = {{"schema", "trammel/error/1"},
                 {"exit_code", static_cast<int>(code)},
                 {"kind", kind_of(code)},
                 {"what", text.what}};
  const auto add = [&object](const char* key, const std::string& value) {
    if (!value.empty()) object[key] = value;
  };
  add("file", text.where.file);
  if (text.where.line > 0) object["line"] = text.where.line;
  if (text.where.column > 0) object["column"] = text.where.column;
  add("field", text.where.field);
  add("point", text.where.point);
  add("got", text.got);
  add("expected", text.expected);
  add("hint", text.hint);
  return object;
}

}  // namespace

int fail(ExitCode code, const ErrorText& text, bool json) {
  const auto replace = Json::error_handler_t::replace;
  ErrorText shown = text;
  if (text.got.find(' ') == std::string::npos) shown.got = shortened(text.got, kShownColumnsOfGot);
  std::string line = json ? printable_json(error_json(code, text).dump(-1, ' ', false, replace))
                          : "trammel: " + printable(describe(shown));
  if (const auto columns = terminal_columns(STDERR_FILENO); columns && !json) {
    line = folded(line, *columns);
  }
  std::fputs((line + "\n").c_str(), stderr);  // one that is closed is no reason to abort
  return static_cast<int>(code);
}

namespace {

std::string joined(const std::vector<std::string>& words, const char* between) {
  return fmt::format("{}", fmt::join(words, between));
}

ErrorText unknown_text(const Unknown& unknown) {
  ErrorText text;
  text.what =
      fmt::format("unknown {} '{}'", unknown.is_option ? "option" : "command", unknown.word);
  if (!unknown.suggestions.empty()) {
    text.hint = "did you mean " + joined(unknown.suggestions, " or ") + "?";
  } else {
    text.hint =
        fmt::format("known: {}; see {} --help", joined(unknown.known, ", "), unknown.command);
  }
  return text;
}

ErrorText usage_text(Command app, const std::string& fault, const std::vector<std::string>& words) {
  if (const auto unknown = first_unknown(app, words)) return unknown_text(*unknown);
  Command at = chosen_command(app);
  const std::string name = full_name(at);
  const auto subs = visible_commands(at);
  if (!subs.empty()) {
    std::vector<std::string> names;
    for (const Command sub : subs) names.push_back(sub.name());
    return {.what = name + " needs a command",
            .expected = "one of " + joined(names, ", "),
            .hint = "see " + name + " --help"};
  }
  return {.what = fault, .hint = "see " + name + " --help"};
}

/// One command line on its way: what was typed, and what it means.
struct Line {
  Command app;
  const std::vector<std::string>& words;
  const Context& context;
};

/// Values on the line that name neither a file nor what is stored are of the line. No campaign of a
/// name is found in the database, what is in a campaign without naming that.
Fault fault_of(ExitCode code, const ErrorText& text, const std::vector<std::string>& words,
               const Context& context) {
  const std::filesystem::path file = text.where.file;
  const bool of_options = text.where.file.starts_with("parameters of ");
  if (!file.empty() && !of_options) {
    const std::string name = file.filename().string();
    if (name == std::filesystem::path(context.db()).filename()) return Fault::stored;
    const bool named = std::ranges::any_of(
        words, [&name](const std::string& word) { return word.find(name) != std::string::npos; });
    return named ? Fault::file : Fault::file_of_another;
  }
  return code == ExitCode::not_found ? Fault::part : Fault::line;
}

/// The commands that a hint has in `quotes`, of the database of this line.
std::string hint_of_the_same(const std::string& hint, const Context& context) {
  std::string text;
  for (std::size_t at = 0; at < hint.size();) {
    const std::size_t open = hint.find("`trammel ", at);
    const std::size_t close = open == std::string::npos ? open : hint.find('`', open + 1);
    if (close == std::string::npos) return text + hint.substr(at);
    text += hint.substr(at, open + 1 - at) +
            context.of_the_same(hint.substr(open + 1, close - open - 1)) + "`";
    at = close + 1;
  }
  return text;
}

/// The error, and what to do next where its text does not say.
int fail_with_advice(ExitCode code, ErrorText text, const Line& line) {
  const std::string next = next_step_after_error(line.app, line.words, code,
                                                 fault_of(code, text, line.words, line.context));
  const bool advise = text.hint.empty();
  text.hint = hint_of_the_same(text.hint, line.context);
  if (advise && line.context.json) text.hint = line.context.of_the_same(next);
  fail(code, text, line.context.json);
  if (advise) line.context.next(next);
  return static_cast<int>(code);
}

/// The command, with what it prints in the file of --out.
ExitCode chosen_into(const Context& context) {
  if (context.out.empty()) return context.chosen();
  Sink sink(context.out, context.existing());
  const ExitCode code = context.chosen();
  sink.deliver();
  return code;
}

int run_chosen(const Line& line) {
  const Context& context = line.context;
  try {
    const ExitCode code = chosen_into(context);
    if (!context.suggested) {
      const std::string next = next_step(line.app, line.words, code);
      if (!next.empty()) context.next(next);
    }
    return static_cast<int>(code);
  } catch (const Error& error) {
    return fail_with_advice(error.code(), error.text(), line);
  } catch (const Json::exception& error) {
    // Files of users are read with their lines and fields: this is text from the database.
    return fail(ExitCode::storage,
                {.what = "stored JSON is not what this program writes",
                 .where = {.file = context.db()},
                 .got = error.what(),
                 .hint = "see `trammel db verify`"},
                context.json);
  } catch (const std::bad_alloc&) {
    return fail_with_advice(ExitCode::error, {.what = "out of memory"}, line);
  } catch (const std::exception& error) {
    return fail_with_advice(ExitCode::error, {.what = error.what()}, line);
  }
}

/// Version or help in the place of the command. The line was read no farther than to the word that
/// asks for them, so --out and --overwrite are looked for here.
int print_instead(const std::function<void()>& print, const Line& line, Context& context) {
  for (std::size_t k = 0; k < line.words.size(); ++k) {
    const std::string& word = line.words[k];
    if (word.starts_with("--out=")) context.out = word.substr(6);
    if (word == "--out" && k + 1 < line.words.size()) context.out = line.words[k + 1];
    context.overwrite = context.overwrite || word == "--overwrite";
  }
  context.suggested = true;  // nothing comes next
  context.chosen = [&print] {
    print();
    return ExitCode::ok;
  };
  return run_chosen(line);
}

constexpr std::size_t kShownColumns = 30;  // of a word that is refused

/// Numbers on the line are read as strictly as in files: decimal, within kLargestNumber, nothing
/// after them.
void only_decimal_numbers(Command command) {
  const auto number = [](const std::string& word) {
    const auto value = parse_number(word);
    if (!value) return "'" + shortened(word, kShownColumns) + "' is no decimal number";
    if (std::abs(*value) <= kLargestNumber) return std::string();
    return "'" + shortened(word, kShownColumns) + "' is beyond all machines and laboratories";
  };
  const auto count = [](const std::string& word) {
    return parse_integer(word) ? std::string()
                               : "'" + shortened(word, kShownColumns) + "' is no whole number";
  };
  for (const Option option : command.options()) {
    const std::string type = option.type_text();
    if (type.starts_with("FLOAT")) option.check(number);
    if (type.starts_with("INT") || type.starts_with("UINT")) option.check(count);
  }
  for (const Command below : command.commands()) only_decimal_numbers(below);
}

enum class Explain { no, yes };

/// The line as the program with these commands alone takes it. What they are is 3 ms of work, so
/// they are first those that the line names; a line that these do not understand, or that asks for
/// help, is not answered: that needs the whole tree, and is to be explained from it.
std::optional<int> run_among(const std::vector<ProgramCommand>& commands,
                             const std::vector<std::string>& words, Explain explain) {
  Context context;
  CommandLine app;
  set_up(app, context, commands);
  const auto [outcome, text] = app.parse(words);
  const bool json = std::ranges::find(words, "--json") != words.end();
  if (outcome == CommandLine::Outcome::version_wanted) {
    return print_instead(
        [&] { json ? context.print("version", version_json()) : context.print_as_is(text); },
        {app, words, context}, context);
  }
  if (outcome != CommandLine::Outcome::ok && explain == Explain::no) return std::nullopt;
  if (outcome == CommandLine::Outcome::help_wanted) {
    for (const auto& prepare : context.before_help) prepare();
    return print_instead([&] { context.print(app.help()); }, {app, words, context}, context);
  }
  if (outcome == CommandLine::Outcome::wrong) {
    return fail(ExitCode::usage, usage_text(app, text, words), json);
  }
  context.machine = named_machine(chosen_command(app));
  return run_chosen({app, words, context});
}

}  // namespace

const std::array<ExitMeaning, 10>& exit_codes() { return kCodes; }

std::string exit_codes_text() {
  std::string text = "Exit codes:\n";
  for (const ExitMeaning& row : kCodes) {
    text += fmt::format("  {:>3}  {}\n", static_cast<int>(row.code), row.meaning);
  }
  return text;
}

void set_up(CommandLine& app, Context& context, const std::vector<ProgramCommand>& commands) {
  app.describe(
      "Plans, runs, records, calibrates, explains and reports measurement campaigns on planar "
      "machines driven by linear axes: 3-PRR, 3-RPR and 3-PPR robots, XY stages, single axes.",
      "\n" + exit_codes_text() +
          "stdout is data, stderr is talk. Anywhere on the line: --json (one JSON object instead "
          "of\ntext), --quiet (errors only), --db FILE (else TRAMMEL_DB, else ./trammel.db), "
          "--out FILE\n(what is printed goes there), "
          "--overwrite (replace an output file of the same format).\n"
          "`trammel archive` is the program of the package trammel-archive.\n"
          "NO_COLOR is honoured. `trammel man` prints all of this as a man page.",
      "trammel " + store::this_program().tool_version);
  app.option("--db", context.db_option, "Database file").type("FILE").check([](const auto& word) {
    return std::string(word.empty() ? "a database has a name" : "");
  });
  app.flag("--json", context.json, "Print one JSON object instead of text");
  app.flag("--quiet", context.quiet, "No talk on stderr, errors only");
  app.option("--out", context.out, "File to write instead of stdout").type("FILE");
  app.flag("--overwrite", context.overwrite, "Replace an output file of the same format");
  for (const ProgramCommand& command : commands) command.setup(app, context);
  only_decimal_numbers(app);
}

namespace {

/// What was printed may still be lost: a full disk behind stdout, a closed pipe. Looked at once, at
/// the end; ferror remembers what failed on the way.
int with_output_delivered(int code, const std::vector<std::string>& words) {
  const bool delivered = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  std::clearerr(stdout);
  if (delivered || (code != 0 && code != static_cast<int>(ExitCode::not_acceptable))) return code;
  return fail(ExitCode::error,
              {.what = "could not write all of the output to stdout",
               .hint = "is there space where it goes?"},
              std::ranges::find(words, "--json") != words.end());
}

}  // namespace

int run_cli(const std::vector<std::string>& words, const std::vector<ProgramCommand>& commands) {
  std::vector<ProgramCommand> named;
  std::ranges::copy_if(
      commands, std::back_inserter(named), [&words](const ProgramCommand& command) {
        return command.name != nullptr && std::ranges::find(words, command.name) != words.end();
      });
  auto code = run_among(named, words, Explain::no);
  if (!code) code = run_among(commands, words, Explain::yes);
  return with_output_delivered(code.value(), words);
}

}  // namespace trammel::cli
