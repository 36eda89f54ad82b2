#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// calibrate STAGE CAMPAIGN: one subcommand per stage of app/job/stages.hpp.
void setup_calibrate(Command app, Context& context);

}  // namespace trammel::cli
