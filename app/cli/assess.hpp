#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct AssessOptions {
  std::string campaign, session, job;
};

/// `assess CAMPAIGN`: accuracy and repeatability by ISO 9283 and ISO 230-2, uncertainty of a job's
/// correction.
void setup_assess(Command app, Context& context);
ExitCode run_assess(const AssessOptions& options, Context& context);

}  // namespace trammel::cli
