#pragma once

#include "app/cli/context.hpp"
#include "core/plan/check.hpp"

namespace trammel::cli {

/// Margins and speeds a plan is checked against.
void margin_options(Command command, CheckOptions& check);

}  // namespace trammel::cli
