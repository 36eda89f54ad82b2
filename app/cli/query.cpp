#include "app/cli/query.hpp"

#include <algorithm>
#include <cctype>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/cli/cli.hpp"
#include "app/files/csv.hpp"
#include "app/files/numbers.hpp"
#include "app/report/accuracy.hpp"
#include "app/terminal/table.hpp"
#include "store/open.hpp"
#include "store/query.hpp"

namespace trammel::cli {

namespace {

using store::Cell;

std::string text_of(const Cell& cell) {
  if (const auto* integer = std::get_if<std::int64_t>(&cell)) return std::to_string(*integer);
  if (const auto* real = std::get_if<double>(&cell)) return number_text(*real);
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  return "";
}

std::string csv_text(const Cell& cell) {
  const bool is_text = std::holds_alternative<std::string>(cell);
  return csv_cell(is_text ? defused(text_of(cell)) : text_of(cell));
}

Json json_of(const Cell& cell) {
  return std::visit([](const auto& value) { return Json(value); }, cell);
}

// Two columns of one name would be one key.
std::vector<std::string> distinct(const std::vector<std::string>& names) {
  std::vector<std::string> keys;
  for (const std::string& name : names) {
    std::string key = name;
    for (int n = 2; std::ranges::find(keys, key) != keys.end(); ++n) {
      key = name + "_" + std::to_string(n);
    }
    keys.push_back(key);
  }
  return keys;
}

void print_csv(const Answer& answer, const Context& context) {
  const auto line = [&](const auto& values, auto text) {
    std::string joined;
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (k > 0) joined += ',';
      joined += text(values[k]);
    }
    context.print_as_is(joined);
  };
  line(answer.columns, [](const std::string& name) { return csv_text(name); });
  while (const auto row = answer.next()) line(*row, csv_text);
}

void print_json(const Answer& answer, bool lines, const Context& context) {
  const std::vector<std::string> keys = distinct(answer.columns);
  Json rows = Json::array();
  while (const auto row = answer.next()) {
    Json object = Json::object();
    for (std::size_t k = 0; k < keys.size(); ++k) object[keys[k]] = json_of((*row)[k]);
    if (lines) {
      context.print_as_is(
          printable_json(object.dump(-1, ' ', false, Json::error_handler_t::replace)));
    } else {
      rows.push_back(std::move(object));
    }
  }
  if (!lines) context.print("query", {{"columns", keys}, {"rows", std::move(rows)}});
}

void print_text(const Answer& answer, const Context& context) {
  Table table(answer.columns);
  while (const auto row = answer.next()) {
    std::vector<std::string> cells;
    for (const Cell& cell : *row) cells.push_back(text_of(cell));
    table.add(std::move(cells));
  }
  context.print(table.text());
}

/// Anywhere in the question: the table is computed before SQLite reads it.
bool names_accuracy(std::string sql) {
  std::ranges::transform(sql, sql.begin(), [](unsigned char c) { return std::tolower(c); });
  return sql.find("v_accuracy") != std::string::npos;
}

/// The time limit where SQLite doesn't look at it: one function of one row may take minutes, and
/// nothing interrupts that. The process ends instead; it only reads.
class HardLimit {
 public:
  HardLimit(std::chrono::milliseconds limit, const Context& context)
      : thread_([limit, &context](const std::stop_token& ended) {
          std::mutex mutex;
          std::unique_lock lock(mutex);
          std::condition_variable_any never;
          never.wait_for(lock, ended, limit + kGrace, [] { return false; });
          if (ended.stop_requested()) return;
          std::_Exit(fail(ExitCode::storage,
                          {.what = "the query took too long",
                           .where = {.file = context.db()},
                           .hint = "ask for less, or allow it more time (--timeout-s)"},
                          context.json));
        }) {}

 private:
  static constexpr std::chrono::milliseconds kGrace{500};  // in which SQLite should have ended it
  std::jthread thread_;
};

}  // namespace

ExitCode run_query(const QueryOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  if (names_accuracy(options.sql)) store::provide(db, report::accuracy(db));
  const auto limit = std::chrono::milliseconds(static_cast<long>(options.timeout_s * 1000));
  const HardLimit hard(limit, context);
  store::Query query(db, options.sql, limit);
  print_answer({query.columns(), [&query] { return query.next(); }}, options, context);
  return ExitCode::ok;
}

void print_answer(const Answer& answer, const QueryOptions& options, const Context& context) {
  if (context.json && (options.csv || options.ndjson)) {
    throw UsageError({.what = "--json prints one object, --csv and --ndjson print others",
                      .expected = "one of them"});
  }
  if (options.csv) {
    print_csv(answer, context);
  } else if (context.json || options.ndjson) {
    print_json(answer, options.ndjson, context);
  } else {
    print_text(answer, context);
  }
}

void setup_query_options(Command query, QueryOptions& options) {
  query.option("SQL", options.sql, "One SELECT, or the name of a table or view: all of it")
      .required();
  const Option csv = query.flag("--csv", options.csv, "Comma-separated values");
  query.flag("--ndjson", options.ndjson, "One JSON object a line").excludes(csv);
  query
      .option("--timeout-s,--timeout_s", options.timeout_s,
              "Stop after so many seconds (default 30)")
      .range(0.001, 86400.0);
}

void setup_query(Command app, Context& context) {
  const auto options = std::make_shared<QueryOptions>();
  Command query = app.command(
      "query",
      "Run one SELECT on the database, read only; export a table or view.\n"
      "Views: v_accuracy, v_point_error, v_job, v_job_point, v_drift, v_point_status; see\n"
      "store/README.md. "
      "Ten queries with their answers: examples/queries");
  setup_query_options(query, *options);
  query.option("--archive", options->archive, "Query this archive (by the program trammel-archive)")
      .type("URI");
  on_run(query, context, options, run_query);
}

}  // namespace trammel::cli
