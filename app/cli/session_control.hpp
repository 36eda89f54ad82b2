#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// session status|pause|stop|recover: what another terminal does about a session.
void setup_session_control(Command app, Context& context);

}  // namespace trammel::cli
