#pragma once
// What every command shares: the database's path, --json, where data and talk go.
//
// A command is one file pair app/cli/NAME.{hpp,cpp} with an options struct, setup_NAME(app,
// context) and run_NAME(options, context), and one line in commands.cpp.

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "app/cli/command_line.hpp"
#include "app/files/files.hpp"
#include "app/terminal/text.hpp"
#include "core/error.hpp"

namespace trammel::cli {

/// Objects we print keep their order: a reader sees "schema" first.
using Json = nlohmann::ordered_json;

using namespace terminal;  // tables, columns, safe text

struct Context {
  std::string db_option;  // --db as given; empty when not
  bool json = false;
  bool quiet = false;
  bool overwrite = false;
  std::string out;      // --out as given: stdout of commands that have no --out of their own
  std::string machine;  // the file of one that the line names: next_step.hpp
  std::function<ExitCode()> chosen;                // the command that the words on the line name
  std::vector<std::function<void()>> before_help;  // what shows less where the line says more

  /// --db FILE, else TRAMMEL_DB, else ./trammel.db
  [[nodiscard]] std::string db() const;

  /// Data: text as it is (a newline is added when missing), to stdout; on a terminal, lines that
  /// are longer go on at the next word.
  void print(std::string_view text) const;
  /// Data that is a file's content: as it is; on a terminal without what would act on it.
  void print_as_is(std::string_view text) const;
  /// Data with --json: one object, "schema" = "trammel/<command>/1" first.
  void print(std::string_view command, const Json& fields) const;
  /// Talk, to stderr; nothing with --quiet.
  void say(std::string_view text) const;
  /// The next step, suggested after success and failure: "next: trammel report paper", of the same
  /// (below). Not with --json. A command that suggests nothing itself has a row in next_step.cpp.
  void next(std::string_view command) const;
  /// The command as a shell takes it, with the --db of this line and, where it makes or checks a
  /// plan, its machine. Proof: next_lines_test.cpp.
  [[nodiscard]] std::string of_the_same(std::string_view command) const;

  /// --overwrite: what becomes of an output file that is there already.
  [[nodiscard]] Existing existing() const {
    return overwrite ? Existing::replace : Existing::refuse;
  }

  mutable bool suggested = false;  // next() was called
};

/// The noun `name` ("campaign"), made on first use, so that several files can add verbs to it.
Command noun(Command app, const std::string& name, const std::string& description);

/// Runs `run` when the words on the line name `command`. The help lists the exit codes.
void on_run(Command command, Context& context, std::function<ExitCode()> run);

/// `options` is what the command's options were bound to.
template <class Options>
void on_run(Command command, Context& context, std::shared_ptr<Options> options,
            ExitCode (*run)(const Options&, Context&)) {
  on_run(command, context, [&context, options, run] { return run(*options, context); });
}

}  // namespace trammel::cli
