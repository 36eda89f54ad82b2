#include "store/guard.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace trammel::store {

namespace {

constexpr std::array<std::string_view, 9> kHarmlessPragmas = {
    "user_version",   "application_id", "quick_check",  "integrity_check", "foreign_key_check",
    "wal_checkpoint", "table_info",     "data_version", "page_count"};

constexpr std::array<std::string_view, 4> kAttemptColumns = {"status", "n_readings", "detail",
                                                             "closed_utc"};

bool is_harmless_pragma(const char* name, const char* argument) {
  const bool sets = argument != nullptr && std::string_view(name).ends_with("_version");
  return !sets &&
         std::ranges::find(kHarmlessPragmas, std::string_view(name)) != kHarmlessPragmas.end() &&
         (argument == nullptr || std::string_view(name) != "application_id");
}

int allow(bool yes) { return yes ? SQLITE_OK : SQLITE_DENY; }

int only_select(void*, int action, const char* first, const char* second, const char*,
                const char*) {
  switch (action) {
    case SQLITE_SELECT:
    case SQLITE_READ:
    case SQLITE_RECURSIVE:
    case SQLITE_TRANSACTION:
      return SQLITE_OK;
    case SQLITE_FUNCTION:
      return allow(std::string_view(second) != "load_extension");
    case SQLITE_PRAGMA:
      return allow(is_harmless_pragma(first, second));
    default:
      return SQLITE_DENY;
  }
}

int only_add(void* unused, int action, const char* first, const char* second, const char* database,
             const char* trigger) {
  switch (action) {
    case SQLITE_INSERT:
      return allow(!std::string_view(first).starts_with("sqlite_"));
    case SQLITE_SAVEPOINT:
      return SQLITE_OK;
    case SQLITE_UPDATE:
      return allow(std::string_view(first) == "attempt" &&
                   std::ranges::find(kAttemptColumns, std::string_view(second)) !=
                       kAttemptColumns.end());
    default:
      return only_select(unused, action, first, second, database, trigger);
  }
}

}  // namespace

void guard_writes(Connection& connection) {
  sqlite3_set_authorizer(connection.handle(), only_add, nullptr);
}

void guard_reads(Connection& connection) {
  sqlite3_set_authorizer(connection.handle(), only_select, nullptr);
}

}  // namespace trammel::store
