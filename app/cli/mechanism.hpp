#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// mechanism check|fk|ik|sensitivity|workspace FILE
void setup_mechanism(Command app, Context& context);

}  // namespace trammel::cli
