#pragma once

#include <memory>

#include "app/cli/context.hpp"

namespace trammel::cli {

/// Help as this program writes it: values by name, descriptions wrapped to the terminal (to 100
/// columns where there is none).
std::shared_ptr<CLI::Formatter> help_formatter();

}  // namespace trammel::cli
