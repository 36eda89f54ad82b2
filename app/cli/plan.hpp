#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// plan create|show|check
void setup_plan(Command app, Context& context);

}  // namespace trammel::cli
