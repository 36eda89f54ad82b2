#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

struct CompletionOptions {
  std::string shell;
};
struct CompleteOptions {
  Command app;
  std::vector<std::string> words;
};

/// `completion SHELL`: the script that a shell reads; and, hidden, `complete -- WORDS`, which that
/// script asks at each TAB.
void setup_completion(Command app, Context& context);
ExitCode run_completion(const CompletionOptions& options, Context& context);
ExitCode run_complete(const CompleteOptions& options, Context& context);

}  // namespace trammel::cli
