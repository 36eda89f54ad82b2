#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// `trammel emulate galil|tracker`: the device emulators as servers, until Ctrl-C or SIGTERM.
void setup_emulate(Command app, Context& context);

}  // namespace trammel::cli
