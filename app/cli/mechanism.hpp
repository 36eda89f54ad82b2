#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// mechanism check|fk|ik|sensitivity|workspace FILE
void setup_mechanism(CLI::App& app, Context& context);

}  // namespace trammel::cli
