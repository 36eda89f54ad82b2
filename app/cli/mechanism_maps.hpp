#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// mechanism sensitivity|workspace FILE: what is computed over a grid of poses.
void setup_mechanism_maps(Command mechanism, Context& context);

}  // namespace trammel::cli
