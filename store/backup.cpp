#include "store/backup.hpp"

#include <fcntl.h>
#include <unistd.h>

#include "store/guard.hpp"
#include "store/migrations.hpp"
#include "store/open.hpp"
#include "store/statement.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

std::string quoted(const std::string& text) {
  std::string sql = "'";
  for (const char c : text) sql += c == '\'' ? "''" : std::string(1, c);
  return sql + "'";
}

void sync(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!synced) {
    throw StoreError({.what = "the copy could not be synced", .where = {.file = path.string()}});
  }
}

// Removes what is left of a copy that came to nothing.
struct Partial {
  std::filesystem::path path;
  ~Partial() {
    std::error_code ignored;
    for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
      std::filesystem::remove(path.string() + suffix, ignored);
    }
  }
};

CheckReport whole(Connection& connection, const std::filesystem::path& file) {
  CheckReport report = verify(connection);
  if (report.ok()) return report;
  throw StoreError({.what = "the database is damaged, and so would be its copy",
                    .where = {.file = file.string()},
                    .got = report.findings.front(),
                    .hint = "see `trammel db verify`"});
}

CheckReport verified(const std::filesystem::path& copy) {
  Connection connection = open(copy, Access::read_only);
  return whole(connection, copy);
}

void require_free(const std::filesystem::path& to) {
  if (!std::filesystem::exists(to)) return;
  throw InputError({.what = "the backup's name is taken",
                    .where = {.file = to.string()},
                    .hint = "name a new file"});
}

}  // namespace

CheckReport backup_check(const std::filesystem::path& file, const std::filesystem::path& to) {
  require_free(to);
  Connection connection = open(file, Access::read_only);
  return whole(connection, file);
}

CheckReport backup(const std::filesystem::path& file, const std::filesystem::path& to) {
  require_free(to);
  { open(file, Access::read_only); }  // is it ours?
  const Partial partial{to.string() + ".part"};
  { const Partial left_by_a_dead_one{partial.path}; }
  Connection(file, Access::read_only).execute("VACUUM INTO " + quoted(partial.path.string()));
  CheckReport report = verified(partial.path);
  sync(partial.path);
  std::filesystem::rename(partial.path, to);
  sync(std::filesystem::absolute(to).parent_path());
  return report;
}

Migration planned_migration(const std::filesystem::path& file) {
  Migration plan{.from = 0, .to = newest_version(), .copy = {}};
  Connection before = open(file, Access::read_only);
  plan.from = version_of(before);
  if (plan.from == plan.to) return plan;
  const std::string name = file.string() + ".v" + std::to_string(plan.from) + "-backup";
  plan.copy = name;
  // One that stands there may be of another day, or of a step that failed: it is left alone.
  for (int n = 2; std::filesystem::exists(plan.copy); ++n) plan.copy = name + std::to_string(n);
  return plan;
}

Migration migrate(const std::filesystem::path& file) {
  const Migration done = planned_migration(file);
  if (done.from == done.to) return done;
  backup(file, done.copy);
  Connection connection(file, Access::write);
  connection.execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL");
  guard_migration(connection);
  Transaction transaction(connection);
  for (int v = version_of(connection); v < done.to; ++v) {
    connection.execute(migrations()[static_cast<std::size_t>(v)]);
  }
  connection.execute("PRAGMA user_version = " + std::to_string(done.to));
  check_identity(connection);
  transaction.commit();
  return done;
}

}  // namespace trammel::store
