#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// plan create|show|check
void setup_plan(CLI::App& app, Context& context);

}  // namespace trammel::cli
