#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

/// mechanism sensitivity|workspace FILE: what is computed over a grid of poses.
void setup_mechanism_maps(CLI::App& mechanism, Context& context);

}  // namespace trammel::cli
