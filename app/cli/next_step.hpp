#pragma once

#include <string>
#include <vector>

#include "app/cli/context.hpp"
#include "core/mechanism/machine.hpp"

namespace trammel::cli {

/// What a person does next after the command that ended with `code`, as a line to type; empty when
/// nothing is suggested. `words`: the line that was run; after a dry run it is the same without
/// --dry-run. Proof: every_command_test.cpp.
std::string next_step(Command app, const std::vector<std::string>& words, ExitCode code);

/// "trammel calibrate lsq ", the paper's method, for its kind of robot; "… geometry " for every
/// other.
std::string first_calibration(const Machine& machine);

/// The file of the machine that the line is about: of --mechanism, of --stage, of `mechanism …`;
/// empty when it names none.
std::string named_machine(Command command);

/// What an error that suggests nothing itself is about; part: of a campaign that is there;
/// file_of_another: a file that the line does not name, but one that it names.
enum class Fault { stored, part, file, file_of_another, line };

/// The same after such an error. A line that is wrong itself is not suggested again: its help is.
/// Proof: next_step_test.cpp.
std::string next_step_after_error(Command app, const std::vector<std::string>& words, ExitCode code,
                                  Fault fault);

}  // namespace trammel::cli
