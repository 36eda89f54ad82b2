#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// job list|show|why|diff|verify|rerun
void setup_job(Command app, Context& context);

}  // namespace trammel::cli
