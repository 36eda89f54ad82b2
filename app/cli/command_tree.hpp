#pragma once
// What help, the man page, completion and suggestions read from the tree of commands.

#include <optional>
#include <string>
#include <vector>

#include "app/cli/command_line.hpp"

namespace trammel::cli {

/// The verbs of a noun (the commands of the program) that a user sees, in order.
std::vector<Command> visible_commands(Command app);

/// The verb or command named `word`, hidden ones too; none when there is no such one.
std::optional<Command> find_command(Command app, const std::string& word);

/// The command that the parsed line names: "import" of "trammel campaign import".
Command chosen_command(Command app);

/// "trammel campaign import"
std::string full_name(Command app);

/// Options of the command and, as they fall through, of those above it.
std::vector<Option> options_of(Command app);

/// The option named `word` ("--db"); none when the command has no such option.
std::optional<Option> find_option(Command app, const std::string& word);

std::vector<Option> positionals_of(Command app);

/// What is to be written for a value: "FILE", "CAMPAIGN", "NUMBER", "N"; empty for a flag. It is
/// the option's type_name, else for text its own name in capitals: --order ORDER.
std::string value_name(Option option);

/// The words that may be given, where these are fixed ("D", "A", "E").
std::vector<std::string> choices_of(Option option);

/// The description with choices, default and whether it must be given.
std::string described(Option option);

/// A word of the command line that is meant as an option: it is no negative number.
bool looks_like_option(const std::string& word);

}  // namespace trammel::cli
