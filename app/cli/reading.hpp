#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct ReadingExcludeOptions {
  std::string campaign;
  int seq = 0;
  std::string reason;
  bool dry_run = false;
};

/// `reading exclude`: later jobs leave the reading out; it stays stored.
void setup_reading(Command app, Context& context);

ExitCode run_reading_exclude(const ReadingExcludeOptions& options, Context& context);

}  // namespace trammel::cli
