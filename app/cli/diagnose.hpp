#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

void setup_diagnose(CLI::App& app, Context& context);

}  // namespace trammel::cli
