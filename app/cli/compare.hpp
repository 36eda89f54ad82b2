#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct CompareOptions {
  std::string a, b;
};

/// `compare A B`: the figures two campaigns have in common, side by side.
void setup_compare(Command app, Context& context);
ExitCode run_compare(const CompareOptions& options, Context& context);

}  // namespace trammel::cli
