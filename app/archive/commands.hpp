#pragma once

#include "app/cli/context.hpp"

namespace trammel::archive {

/// `trammel archive VERB`, the one noun of the program trammel-archive.
void setup_archive(cli::Command app, cli::Context& context);

}  // namespace trammel::archive
