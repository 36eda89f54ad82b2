#pragma once
// The parts of a help as this program writes them: values by name, descriptions wrapped to the
// terminal (to 100 columns where there is none).

#include <string>

#include "app/cli/command_line.hpp"

namespace trammel::cli {

/// `as_argument`: among those; an option that may also stand as one is in both lists.
std::string option_help(Option option, bool as_argument);
std::string positional_usage(Option option);
std::string command_help(const std::string& name, const std::string& description);
std::string description_help(const std::string& description);
std::string footer_help(const std::string& footer);

}  // namespace trammel::cli
