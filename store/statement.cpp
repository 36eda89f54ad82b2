#include "store/statement.hpp"

#include <sqlite3.h>

namespace trammel::store {

namespace {

// SQLite answers nothing for NULL, for an empty blob, and where it found no memory.
void require_memory(const Connection& connection) {
  if (sqlite3_errcode(connection.handle()) == SQLITE_NOMEM) {
    throw connection.error(SQLITE_NOMEM, "read a column");
  }
}

/// A name that is empty or too long is its giver's fault: the database is sound.
void refuse_name(const ErrorText& error) {
  if (error.got.find("CHECK constraint failed: length(name)") == std::string::npos) return;
  throw InputError({.what = "a name that is empty or too long",
                    .where = {.field = "name"},
                    .expected = "1 to 200 characters"});
}

}  // namespace

Statement::Statement(Connection& connection, std::string_view sql)
    : connection_(connection), sql_(sql) {
  if (const auto idle = connection_.idle_.find(sql); idle != connection_.idle_.end()) {
    statement_ = idle->second;
    connection_.idle_.erase(idle);
    return;
  }
  check(sqlite3_prepare_v3(connection_.db_, sql_.c_str(), static_cast<int>(sql_.size()) + 1,
                           SQLITE_PREPARE_PERSISTENT, &statement_, nullptr));
}

Statement::~Statement() {
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
  try {
    connection_.idle_.emplace(std::move(sql_), statement_);
  } catch (...) {
    sqlite3_finalize(statement_);
  }
}

void Statement::check(int code) const {
  if (code == SQLITE_OK) return;
  const StoreError failure = connection_.error(code, std::string_view(sql_).substr(0, 60));
  refuse_name(failure.text());
  throw failure;
}

Statement& Statement::operator<<(std::int64_t value) {
  check(sqlite3_bind_int64(statement_, next_++, value));
  return *this;
}

Statement& Statement::operator<<(double value) {
  check(sqlite3_bind_double(statement_, next_++, value));
  return *this;
}

Statement& Statement::operator<<(std::string_view value) {
  check(sqlite3_bind_text64(statement_, next_++, value.data() ? value.data() : "", value.size(),
                            SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

Statement& Statement::operator<<(Bytes value) {
  check(sqlite3_bind_blob64(statement_, next_++, value.data(), value.size(), SQLITE_TRANSIENT));
  return *this;
}

Statement& Statement::operator<<(std::nullopt_t) {
  check(sqlite3_bind_null(statement_, next_++));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) check(code);
  return false;
}

Id Statement::run() {
  while (step()) {
  }
  const Id id = sqlite3_last_insert_rowid(connection_.db_);
  reset();
  return id;
}

void Statement::reset() {
  sqlite3_reset(statement_);
  next_ = 1;
}

int Statement::columns() const { return sqlite3_column_count(statement_); }
bool Statement::is_null(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}
std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}
double Statement::real(int column) const { return sqlite3_column_double(statement_, column); }

std::string Statement::text(int column) const {
  const auto* bytes = sqlite3_column_text(statement_, column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  if (bytes == nullptr) require_memory(connection_);
  return bytes ? std::string(reinterpret_cast<const char*>(bytes), size) : std::string();
}

Bytes Statement::blob(int column) const {
  const auto* bytes = static_cast<const unsigned char*>(sqlite3_column_blob(statement_, column));
  if (bytes == nullptr) require_memory(connection_);
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

std::optional<double> Statement::optional_real(int column) const {
  return is_null(column) ? std::nullopt : std::optional(real(column));
}
std::optional<std::int64_t> Statement::optional_integer(int column) const {
  return is_null(column) ? std::nullopt : std::optional(integer(column));
}
std::optional<std::string> Statement::optional_text(int column) const {
  return is_null(column) ? std::nullopt : std::optional(text(column));
}

}  // namespace trammel::store
