#pragma once
// What help, the man page, completion and suggestions read from the tree of commands.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace trammel::cli {

/// The verbs of a noun (the commands of the program) that a user sees, in order.
std::vector<const CLI::App*> visible_commands(const CLI::App& app);

/// The verb or command named `word`, hidden ones too; none when there is no such one.
const CLI::App* find_command(const CLI::App& app, const std::string& word);

/// The command that the parsed line names: "import" of "trammel campaign import".
const CLI::App& chosen_command(const CLI::App& app);

/// "trammel campaign import"
std::string full_name(const CLI::App& app);

/// Options of the command and, as they fall through, of those above it.
std::vector<const CLI::Option*> options_of(const CLI::App& app);

/// The option named `word` ("--db"); none when the command has no such option.
const CLI::Option* find_option(const CLI::App& app, const std::string& word);

std::vector<const CLI::Option*> positionals_of(const CLI::App& app);

/// What is to be written for a value: "FILE", "CAMPAIGN", "NUMBER", "N"; empty for a flag. It is
/// the option's type_name, else for text its own name in capitals: --order ORDER.
std::string value_name(const CLI::Option& option);

/// The words that may be given, where these are fixed ("D", "A", "E").
std::vector<std::string> choices_of(const CLI::Option& option);

/// The description with choices, default and whether it must be given.
std::string described(const CLI::Option& option);

/// A word of the command line that is meant as an option: it is no negative number.
bool looks_like_option(const std::string& word);

}  // namespace trammel::cli
