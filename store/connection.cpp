#include "store/connection.hpp"

#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace trammel::store {

namespace {

// Longer than any transaction of ours; a session's points are seconds apart.
constexpr int kBusyTimeoutMs = 10'000;
// A job's points of a million readings, as many as a plan may have, take some 75 MB; a row or a
// value of a stranger's file is not larger.
constexpr int kLongestValueBytes = 128 * 1024 * 1024;

std::string uri_of(const std::filesystem::path& file, bool immutable) {
  if (file == ":memory:" || file.empty()) return file.string();
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    if (c == '?' || c == '#' || c == '%') {
      constexpr std::string_view digits = "0123456789ABCDEF";
      uri +=
          {'%', digits[static_cast<std::size_t>(c >> 4)], digits[static_cast<std::size_t>(c & 15)]};
    } else {
      uri += c;
    }
  }
  return immutable ? uri + "?immutable=1" : uri;
}

/// Once for the process, before it begins with SQLite; refused, and so left, where another part
/// has. Memory is not counted: it would take one lock for all threads, and nothing of ours asks.
/// What a statement or a savepoint may have to undo is kept in memory, a job's pages at most: in
/// its temporary file every page of every row of a job was written once more.
void configure_sqlite() {
  constexpr int kNeverSpill = -1;
  static const int once = sqlite3_config(SQLITE_CONFIG_MEMSTATUS, 0) |
                          sqlite3_config(SQLITE_CONFIG_STMTJRNL_SPILL, kNeverSpill);
  static_cast<void>(once);
}

bool writable(const std::filesystem::path& folder) { return access(folder.c_str(), W_OK) == 0; }

// In a folder that can not be written SQLite has no place for its -shm: without a -wal the file is
// whole by itself and is read as it stands.
bool stands_still(const std::filesystem::path& file) {
  std::error_code ignored;
  return !writable(std::filesystem::absolute(file).parent_path()) &&
         !std::filesystem::exists(file.string() + "-wal", ignored);
}

struct Advice {
  int code;
  const char* what;
  const char* hint;
};

constexpr std::array kAdvice = {
    Advice{SQLITE_BUSY, "the database is in use by another process", "wait for it, or stop it"},
    Advice{SQLITE_LOCKED, "the database is in use", "finish the other operation first"},
    Advice{SQLITE_READONLY, "the database can not be written",
           "check the permissions of the file and its folder"},
    Advice{SQLITE_CANTOPEN, "the database cannot be opened",
           "check that the file and its folder exist and may be read and written"},
    Advice{SQLITE_NOTADB, "this file is not a database of trammel", "name another file with --db"},
    Advice{SQLITE_CORRUPT, "the database is damaged",
           "restore a backup, or see `trammel db check`"},
    Advice{SQLITE_FULL, "the disk is full", "nothing of this step was stored; make room"},
    Advice{SQLITE_IOERR, "reading or writing the disk failed",
           "nothing of this step was stored; check the disk"},
    Advice{SQLITE_NOMEM, "out of memory", ""},
    Advice{SQLITE_CONSTRAINT, "the database refused a row", ""},
    Advice{SQLITE_AUTH, "the database refused this operation",
           "what is stored is never changed or deleted"},
    Advice{SQLITE_INTERRUPT, "the query took too long", "ask for less, or allow it more time"},
    Advice{SQLITE_TOOBIG, "a value is too large for a question",
           "ask for the table by its name, or for less of it"},
};

}  // namespace

std::string read_only_uri(const std::filesystem::path& file) {
  return stands_still(file) ? uri_of(file, true) : uri_of(file, false) + "?mode=ro";
}

void Connection::stand_for(const std::filesystem::path& file) {
  file_ = file;
  access_ = Access::read_only;
}

Connection::Connection(const std::filesystem::path& file, Access access)
    : file_(file), access_(access) {
  configure_sqlite();
  std::error_code ignored;
  if (access != Access::create && !std::filesystem::exists(file, ignored)) {
    throw NotFoundError({.what = "there is no database",
                         .where = {.file = file.string()},
                         .hint = "name it with --db FILE or TRAMMEL_DB"});
  }
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored)) {
    const bool folder = std::filesystem::is_directory(file, ignored);
    throw StoreError({.what = "the database cannot be opened",
                      .where = {.file = file.string()},
                      .got = folder ? "a folder" : "a device or a pipe",
                      .expected = "a file"});
  }
  if (access != Access::read_only && std::filesystem::is_regular_file(file, ignored) &&
      std::filesystem::hard_link_count(file, ignored) > 1) {
    throw StoreError(
        {.what = "the database's file has a second name, and each name has a log of its own: who "
                 "writes by one spoils what was written by the other",
         .where = {.file = file.string()},
         .got = "hard links",
         .expected = "one name",
         .hint = "copy it by `trammel db backup --out FILE` and remove the other name (`find / "
                 "-samefile FILE`)"});
  }
  const bool immutable = access == Access::read_only && stands_still(file);
  const int flags = SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX |
                    (access == Access::read_only ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE) |
                    (access == Access::create ? SQLITE_OPEN_CREATE : 0);
  const int code = sqlite3_open_v2(uri_of(file, immutable).c_str(), &db_, flags, nullptr);
  if (code != SQLITE_OK) {
    StoreError failure = error(code, "open");
    sqlite3_close(db_);
    throw failure;
  }
  sqlite3_extended_result_codes(db_, 1);
  sqlite3_busy_timeout(db_, kBusyTimeoutMs);
  sqlite3_limit(db_, SQLITE_LIMIT_LENGTH, kLongestValueBytes);
  sqlite3_db_config(db_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(db_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(db_, SQLITE_DBCONFIG_ENABLE_FKEY, 1, nullptr);
  sqlite3_db_config(db_, SQLITE_DBCONFIG_DQS_DML, 0, nullptr);
  sqlite3_db_config(db_, SQLITE_DBCONFIG_DQS_DDL, 0, nullptr);
}

Connection::~Connection() {
  for (const auto& [sql, statement] : idle_) sqlite3_finalize(statement);
  sqlite3_close(db_);
}

Connection::Connection(Connection&& other) noexcept
    : db_(std::exchange(other.db_, nullptr)),
      file_(std::move(other.file_)),
      access_(other.access_),
      idle_(std::exchange(other.idle_, {})) {}

void Connection::execute(std::string_view sql) const {
  const int code = sqlite3_exec(db_, std::string(sql).c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) throw error(code, sql.substr(0, 60));
}

StoreError Connection::error(int code, std::string_view doing) const {
  ErrorText text{.what = "the database failed",
                 .where = {.file = file_.string()},
                 .got = std::string(db_ ? sqlite3_errmsg(db_) : sqlite3_errstr(code)) +
                        " (SQLite " + std::to_string(code) + ", " + std::string(doing) + ")"};
  for (const Advice& advice : kAdvice) {
    if (advice.code != (code & 0xff)) continue;
    text.what = advice.what;
    text.hint = advice.hint;
  }
  return StoreError(std::move(text));
}

}  // namespace trammel::store
