#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct QueryOptions {
  std::string sql;
  bool csv = false;
  bool ndjson = false;
  double timeout_s = 30;
};

/// `query SQL`: one SELECT, read only, within a time.
void setup_query(Command app, Context& context);

ExitCode run_query(const QueryOptions& options, Context& context);

}  // namespace trammel::cli
