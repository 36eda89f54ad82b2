#pragma once

#include <vector>

#include "app/cli/cli.hpp"

namespace trammel::cli {

/// Every command of the program, one line each, in the order of the help.
const std::vector<ProgramCommand>& commands();

}  // namespace trammel::cli
