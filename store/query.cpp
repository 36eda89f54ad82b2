#include "store/query.hpp"

#include <sqlite3.h>

#include <type_traits>

#include "store/digest.hpp"
#include "store/guard.hpp"

namespace trammel::store {

namespace {

// Steps of SQLite's machine between two looks at the clock: some 0.1 ms.
constexpr int kStepsPerLook = 10'000;
constexpr int kLongestPatternBytes = 1000;

int time_is_over(void* deadline) {
  using Clock = std::chrono::steady_clock;
  return Clock::now() > *static_cast<const Clock::time_point*>(deadline) ? 1 : 0;
}

/// "bounds, …, v_point_error": what a question can be about.
std::string tables_and_views(Connection& connection) {
  Statement find(connection,
                 "SELECT name FROM sqlite_schema WHERE type IN ('table', 'view') UNION SELECT name "
                 "FROM sqlite_temp_schema WHERE type = 'table' ORDER BY name");
  std::string names;
  while (find.step()) names += (names.empty() ? "" : ", ") + find.text(0);
  return names;
}

// What follows the first statement is only white space and comments when SQLite prepares nothing.
bool is_one_statement(Connection& connection, const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  const char* rest = sql.c_str();
  int n = 0;
  while (*rest != '\0') {
    if (sqlite3_prepare_v2(connection.handle(), rest, -1, &statement, &rest) != SQLITE_OK) {
      const std::string got = sqlite3_errmsg(connection.handle());
      throw InputError({.what = "the database cannot run this",
                        .where = {.field = "SQL"},
                        .got = got,
                        .expected = "one SELECT, or the name of a table or view: " +
                                    tables_and_views(connection),
                        .hint = "their columns stand in store/README.md"});
    }
    if (statement != nullptr) ++n;
    sqlite3_finalize(statement);
  }
  return n == 1;
}

std::string select_of(Connection& connection, const std::string& sql) {
  Statement find(connection,
                 "SELECT name FROM sqlite_schema WHERE type IN ('table', 'view') AND name = ?");
  find << sql;
  return find.step() ? "SELECT * FROM \"" + find.text(0) + "\"" : sql;
}

void bind(Statement& insert, const Cell& cell) {
  std::visit(
      [&insert](const auto& value) {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::nullptr_t>) {
          insert << std::nullopt;
        } else {
          insert << value;
        }
      },
      cell);
}

}  // namespace

void provide(Connection& connection, const ComputedTable& table) {
  TRAMMEL_ASSERT(connection.access() == Access::read_only);
  std::string columns, places;
  for (const std::string& column : table.columns) {
    columns += (columns.empty() ? "\"" : ", \"") + column + "\"";
    places += places.empty() ? "?" : ",?";
  }
  // The file stays read-only: it was opened so.
  sqlite3_set_authorizer(connection.handle(), nullptr, nullptr);
  connection.execute("PRAGMA query_only = OFF; PRAGMA temp_store = MEMORY; CREATE TEMP TABLE \"" +
                     table.name + "\" (" + columns + ")");
  {
    Statement insert(connection, "INSERT INTO temp.\"" + table.name + "\" VALUES (" + places + ")");
    for (const std::vector<Cell>& row : table.rows) {
      for (const Cell& cell : row) bind(insert, cell);
      insert.run();
      insert.reset();
    }
  }
  connection.execute("PRAGMA query_only = ON");
  guard_reads(connection);
}

Query::Query(Connection& connection, const std::string& question, std::chrono::milliseconds limit)
    : connection_(connection), deadline_(std::chrono::steady_clock::now() + limit) {
  TRAMMEL_ASSERT(connection.access() == Access::read_only);
  const std::string sql = select_of(connection, question);
  sqlite3* db = connection.handle();
  longest_value_ = sqlite3_limit(db, SQLITE_LIMIT_LENGTH, -1);  // -1 asks
  longest_pattern_ = sqlite3_limit(db, SQLITE_LIMIT_LIKE_PATTERN_LENGTH, kLongestPatternBytes);
  if (sql == question) sqlite3_limit(db, SQLITE_LIMIT_LENGTH, kLongestAnsweredBytes);
  if (is_one_statement(connection, sql)) statement_.emplace(connection, sql);
  if (!statement_ || sqlite3_stmt_readonly(statement_->handle()) == 0 ||
      statement_->columns() == 0) {
    throw InputError({.what = "the database cannot run this",
                      .where = {.field = "SQL"},
                      .expected = "one SELECT"});
  }
  for (int column = 0; column < statement_->columns(); ++column) {
    columns_.emplace_back(sqlite3_column_name(statement_->handle(), column));
  }
  sqlite3_progress_handler(connection.handle(), kStepsPerLook, time_is_over, &deadline_);
}

Query::~Query() {
  sqlite3* db = connection_.handle();
  sqlite3_progress_handler(db, 0, nullptr, nullptr);
  sqlite3_limit(db, SQLITE_LIMIT_LENGTH, longest_value_);
  sqlite3_limit(db, SQLITE_LIMIT_LIKE_PATTERN_LENGTH, longest_pattern_);
}

std::optional<std::vector<Cell>> Query::next() {
  if (!statement_->step()) return std::nullopt;
  std::vector<Cell> row;
  for (int column = 0; column < statement_->columns(); ++column) {
    switch (sqlite3_column_type(statement_->handle(), column)) {
      case SQLITE_INTEGER:
        row.emplace_back(statement_->integer(column));
        break;
      case SQLITE_FLOAT:
        row.emplace_back(statement_->real(column));
        break;
      case SQLITE_TEXT:
        row.emplace_back(statement_->text(column));
        break;
      case SQLITE_BLOB:
        row.emplace_back(hex(statement_->blob(column)));
        break;
      default:
        row.emplace_back(nullptr);
    }
  }
  return row;
}

}  // namespace trammel::store
