#pragma once

#include <vector>

#include "app/cli/cli.hpp"

namespace trammel::cli {

/// Every command of the program, one line each, in the order of the help.
const std::vector<Setup>& commands();

}  // namespace trammel::cli
