#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/context.hpp"
#include "store/query.hpp"

namespace trammel::cli {

struct QueryOptions {
  std::string sql;
  bool csv = false;
  bool ndjson = false;
  double timeout_s = 30;
  std::string archive;  // main.cpp has looked for it
};

/// Rows, whoever gives them: the next one, or none.
struct Answer {
  std::vector<std::string> columns;
  std::function<std::optional<std::vector<store::Cell>>()> next;
};
void print_answer(const Answer& answer, const QueryOptions& options, const Context& context);

/// SQL, --csv, --ndjson, --timeout-s.
void setup_query_options(Command query, QueryOptions& options);

/// `query SQL`: one SELECT, read only, within a time.
void setup_query(Command app, Context& context);

ExitCode run_query(const QueryOptions& options, Context& context);

}  // namespace trammel::cli
