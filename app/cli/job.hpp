#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// job list|show|why|diff|verify|rerun
void setup_job(CLI::App& app, Context& context);

}  // namespace trammel::cli
