#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/cli/context.hpp"

namespace trammel::cli {

/// What adds a command (or verbs of a noun) to `app`.
struct ProgramCommand {
  const char* name;  // as on the line; nullptr: it reads the whole tree, and is never alone in it
  void (*setup)(Command app, Context& context);
};

/// Fills `app` with the options all commands share and with `commands`.
void set_up(CommandLine& app, Context& context, const std::vector<ProgramCommand>& commands);

/// Parses `words`, runs the command they name and returns the exit code, 0 to 130. Errors go to
/// stderr: one line for a person, one object {"schema": "trammel/error/1", …} with --json.
int run_cli(const std::vector<std::string>& words, const std::vector<ProgramCommand>& commands);

/// Says an error as the program does, and returns its exit code.
int fail(ExitCode code, const ErrorText& text, bool json);

struct ExitMeaning {
  ExitCode code;
  const char* kind;  // as in trammel/error/1
  const char* meaning;
};
const std::array<ExitMeaning, 10>& exit_codes();

/// The table of exit codes as help and README show it.
std::string exit_codes_text();

}  // namespace trammel::cli
