#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// `serve CAMPAIGN`: the report as a live page on this machine, until Ctrl-C.
void setup_serve(Command app, Context& context);

}  // namespace trammel::cli
