#include "store/migrate.hpp"

#include <sqlite3.h>

#include "store/new_file.hpp"
#include "store/open.hpp"
#include "store/statement.hpp"
#include "store/take_over.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

void make(const std::filesystem::path& file, int from_version, const std::filesystem::path& part) {
  {
    Connection to(part, Access::create);
    to.execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF");  // it has no name yet
    create_schema(to, newest_version());
    take_over(to, file, from_version);
    to.execute("PRAGMA journal_mode = WAL");
  }
  {
    Connection made = open_as_it_is(part);
    static_cast<void>(whole(made, part));
  }
  sync(part);
}

// A second name for the original, then the new file under its own: FILE is never missing. Where the
// disk knows no second names (FAT), it is for a moment.
void exchange(const std::filesystem::path& file, const std::filesystem::path& part,
              const std::filesystem::path& original) {
  std::error_code failed;
  std::filesystem::create_hard_link(file, original, failed);
  if (failed) std::filesystem::rename(file, original);
  std::filesystem::rename(part, file);
  sync(std::filesystem::absolute(file).parent_path());
}

// All that was stored is then in the file itself, which goes on under its new name alone.
void empty_log(Connection& held) {
  Statement log(held, "PRAGMA wal_checkpoint(TRUNCATE)");
  if (log.step() && log.integer(0) == 0) return;
  throw StoreError({.what = "the database is in use",
                    .where = {.file = held.file().string()},
                    .hint = "stop what reads or writes it, and migrate again"});
}

}  // namespace

Migration planned_migration(const std::filesystem::path& file) {
  Migration plan{.from = 0, .to = newest_version(), .original = {}};
  Connection before = open_as_it_is(file);
  plan.from = version_of(before);
  if (plan.from == plan.to) return plan;
  const std::string name = file.string() + ".v" + std::to_string(plan.from);
  plan.original = name;
  for (int n = 2; std::filesystem::exists(plan.original); ++n) {
    plan.original = name + "-" + std::to_string(n);
  }
  return plan;
}

Migration migrate(const std::filesystem::path& file) {
  const Migration done = planned_migration(file);
  if (done.from == done.to) return done;
  const auto real = std::filesystem::canonical(file);  // a link stays a link
  {
    Connection old = open_as_it_is(file);
    static_cast<void>(whole(old, file));
  }
  Connection held(real, Access::write);
  empty_log(held);
  const std::int64_t before = data_version(held);
  const Partial partial{real.string() + ".part"};
  { const Partial left_by_a_dead_one{partial.path}; }
  make(real, done.from, partial.path);
  // From here on nobody else writes; closing must not touch the log, whose name is the new file's.
  sqlite3_db_config(held.handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  const Transaction nobody_else(held);
  if (data_version(held) != before) {
    throw StoreError({.what = "the database was written while it was taken over",
                      .where = {.file = file.string()},
                      .hint = "stop what writes to it, and migrate again"});
  }
  exchange(real, partial.path, done.original);
  return done;
}

}  // namespace trammel::store
