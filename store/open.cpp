#include "store/open.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <thread>

#include "store/guard.hpp"
#include "store/migrations.hpp"
#include "store/place.hpp"
#include "store/scheme.hpp"
#include "store/statement.hpp"
#include "store/take_over.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

std::int64_t single(Connection& connection, std::string_view sql) {
  Statement statement(connection, sql);
  return statement.step() ? statement.integer(0) : 0;
}

bool is_empty(Connection& connection) {
  return single(connection, "SELECT count(*) FROM sqlite_schema") == 0 &&
         single(connection, "PRAGMA application_id") == 0 && version_of(connection) == 0;
}

struct Object {
  std::string sql;
  std::string table;  // that an index or a trigger is of
};
// By "type name".
using Schema = std::map<std::string, Object>;

Schema read_schema(Connection& connection) {
  Schema schema;
  Statement rows(connection,
                 "SELECT type || ' ' || name, sql, tbl_name FROM sqlite_schema WHERE sql NOT NULL");
  while (rows.step()) schema.emplace(rows.text(0), Object{rows.text(1), rows.text(2)});
  return schema;
}

StoreError not_ours(const Connection& connection, std::string got, std::string expected) {
  return StoreError({.what = "this file is not a database of trammel",
                     .where = {.file = connection.file().string()},
                     .got = std::move(got),
                     .expected = std::move(expected),
                     .hint = "name another file with --db"});
}

// The first of the files that make the schema of a version: 0005 begins anew.
int first_text(int version) { return version < kRedrawn ? 0 : kRedrawn - 1; }

// SQLite keeps the text of each CREATE as our files have it: when there are as many as we made,
// less the views that a later file makes anew, and each stands in the files, all is as it should
// be.
bool is_as_written(const Schema& found, int version) {
  std::string text;
  for (int v = first_text(version); v < version; ++v) {
    text += "\n" + std::string(migrations()[static_cast<std::size_t>(v)]);
  }
  const auto count = [&text](std::string_view words) {
    std::size_t n = 0;
    for (auto at = text.find(words); at != text.npos; at = text.find(words, at + 1)) ++n;
    return n;
  };
  return found.size() == count("\nCREATE ") - count("\nDROP VIEW ") &&
         std::ranges::all_of(found, [&](const auto& object) {
           return text.find("\n" + object.second.sql + ";") != text.npos;
         });
}

// A stranger's file may hold triggers or views that act when it is read or written, and indexes
// that hide rows from whoever asks by them.
void check_schema(Connection& connection, int version) {
  const Schema found = read_schema(connection);
  if (is_as_written(found, version)) return;
  Connection model(":memory:", Access::create);
  create_schema(model, version);
  const Schema expected = read_schema(model);
  for (const auto& [name, object] : expected) {
    const auto it = found.find(name);
    if (it == found.end()) throw not_ours(connection, "no " + name, "the schema of its version");
    if (it->second.sql != object.sql) {
      throw not_ours(connection, "another " + name, "the schema of its version");
    }
  }
  for (const auto& [name, object] : found) {
    const bool own_table = name.starts_with("table ") && !object.sql.starts_with("CREATE VIRTUAL");
    const bool own_index =
        name.starts_with("index ") && !expected.contains("table " + object.table);
    if (expected.contains(name) || own_table || own_index) continue;
    throw not_ours(connection, "an unknown " + name,
                   "no triggers, no views, and no indexes of its tables but its own");
  }
}

// The switch to WAL wants the file for itself, and SQLite does not wait for that: two processes
// that make a database at once are in each other's way.
void use_wal(const Connection& connection) {
  constexpr int kTries = 1000;
  constexpr std::chrono::milliseconds kPause{10};
  for (int n = 1;; ++n) {
    try {
      connection.execute("PRAGMA journal_mode = WAL");
      return;
    } catch (const StoreError&) {
      const bool busy = (sqlite3_errcode(connection.handle()) & 0xff) == SQLITE_BUSY;
      if (!busy || n == kTries) throw;
    }
    std::this_thread::sleep_for(kPause);
  }
}

void initialise(Connection& connection) {
  use_wal(connection);
  Transaction transaction(connection);
  if (!is_empty(connection)) return;  // another process was first
  create_schema(connection, newest_version());
  transaction.commit();
  checkpoint(connection);
}

// A file from anywhere, before it is opened for writing: that alone can run what it holds (a log
// to recover, triggers). Pages are walked where that takes some 30 ms; beyond, `db check` does it.
void look_through(const std::filesystem::path& file) {
  constexpr std::uintmax_t kWalkedBytes = 4u << 20;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size == 0) return;
  // Left by a death while the file was made; only a writer can roll it back.
  if (std::filesystem::exists(file.string() + "-journal", error)) return;
  Connection look(file, Access::read_only);
  look.execute("PRAGMA cell_size_check = ON; PRAGMA query_only = ON");
  if (is_empty(look)) return;
  check_identity(look);
  if (size > kWalkedBytes) return;
  Statement rows(look, "PRAGMA quick_check(1)");
  if (!rows.step() || rows.text(0) == "ok") return;
  throw StoreError({.what = "the database is damaged",
                    .where = {.file = file.string()},
                    .got = rows.text(0),
                    .hint = "nothing is written to it; see `trammel db verify`, restore a backup"});
}

void require_file_name(const std::filesystem::path& file) {
  // SQLite would make a database that is gone with the process: nothing to keep readings in.
  if (!file.empty() && file != ":memory:" && !file.string().starts_with("file:")) return;
  throw StoreError({.what = "this is no name of a database's file",
                    .got = "'" + file.string() + "'",
                    .expected = "a file, by --db or TRAMMEL_DB"});
}

// What an older file holds.
Connection in_this_form(const std::filesystem::path& file, int version) {
  Connection copy("", Access::create);
  copy.execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF");
  create_schema(copy, newest_version());
  take_over(copy, file, version);
  copy.stand_for(file);
  copy.execute("PRAGMA query_only = ON");
  guard_reads(copy);
  return copy;
}

}  // namespace

int newest_version() { return static_cast<int>(migrations().size()); }

int version_of(Connection& connection) {
  return static_cast<int>(single(connection, "PRAGMA user_version"));
}

void create_schema(Connection& connection, int version) {
  connection.execute("PRAGMA application_id = " + std::to_string(kApplicationId));
  for (int v = first_text(version); v < version; ++v) {
    connection.execute(migrations()[static_cast<std::size_t>(v)]);
  }
  connection.execute("PRAGMA user_version = " + std::to_string(version));
}

void check_identity(Connection& connection) {
  const auto id = single(connection, "PRAGMA application_id");
  if (id != kApplicationId) {
    throw not_ours(connection, "application_id " + std::to_string(id),
                   "application_id " + std::to_string(kApplicationId));
  }
  const int version = version_of(connection);
  if (version > newest_version()) {
    throw StoreError({.what = "this database was written by a newer trammel",
                      .where = {.file = connection.file().string()},
                      .got = "version " + std::to_string(version),
                      .expected = "version " + std::to_string(newest_version()) + " or older",
                      .hint = "use the newer program"});
  }
  if (version < 1) throw not_ours(connection, "version " + std::to_string(version), "1 or later");
  if (version < newest_version() && connection.access() != Access::read_only) {
    throw StoreError({.what = "this database was written by an older trammel: it can be read only",
                      .where = {.file = connection.file().string()},
                      .got = "version " + std::to_string(version),
                      .expected = "version " + std::to_string(newest_version()),
                      .hint = "run `trammel db migrate`"});
  }
  check_schema(connection, version);
}

Connection open_as_it_is(const std::filesystem::path& file) {
  require_file_name(file);
  Connection connection(file, Access::read_only);
  connection.execute("PRAGMA cell_size_check = ON; PRAGMA query_only = ON");
  check_identity(connection);
  guard_reads(connection);
  return connection;
}

Connection open(const std::filesystem::path& file, Access access) {
  if (access == Access::read_only) {
    Connection connection = open_as_it_is(file);
    const int version = version_of(connection);
    if (version == newest_version()) return connection;
    return in_this_form(file, version);
  }
  require_file_name(file);
  look_through(file);
  Connection connection(file, access);
  connection.execute("PRAGMA recursive_triggers = ON; PRAGMA cell_size_check = ON");
  if (access == Access::create && is_empty(connection)) initialise(connection);
  check_identity(connection);
  use_wal(connection);
  connection.execute("PRAGMA synchronous = FULL");
  guard_writes(connection);
  return connection;
}

}  // namespace trammel::store
