#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

void setup_diagnose(Command app, Context& context);

}  // namespace trammel::cli
