#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// session run|resume
void setup_session(Command app, Context& context);

}  // namespace trammel::cli
