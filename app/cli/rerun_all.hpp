#pragma once
// `trammel job rerun --all`: an archive calibrated again.

#include "app/cli/context.hpp"

namespace trammel::cli {

struct RerunAllOptions {
  std::string stage;
  std::string where = "1";
  std::string parameters;  // JSON; empty: as each campaign had them
  unsigned threads = 0;    // 0: one per core
};

/// Adds its options to `rerun`; each needs `all`.
void setup_rerun_all(Command rerun, Option all, RerunAllOptions& options);
ExitCode run_rerun_all(const RerunAllOptions& options, bool force, bool dry_run, Context& context);

}  // namespace trammel::cli
