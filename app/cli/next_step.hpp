#pragma once

#include <string>
#include <vector>

#include "app/cli/context.hpp"

namespace trammel::cli {

/// What a person does next after the command that ended with `code`, as a line to type; empty when
/// nothing is suggested. `words`: the line that was run; after a dry run it is the same without
/// --dry-run. Proof: every_command_test.cpp.
std::string next_step(Command app, const std::vector<std::string>& words, ExitCode code);

/// The same after an error that suggests nothing itself. `of_database`: what was not found, or is
/// not right, is stored and no file.
std::string next_step_after_error(Command app, const std::vector<std::string>& words, ExitCode code,
                                  bool of_database);

}  // namespace trammel::cli
