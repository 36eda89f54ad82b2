#include "store/place.hpp"

#include <sqlite3.h>
#include <sys/stat.h>

#include "store/guard.hpp"

namespace trammel::store {

Place::Place(Connection& connection) : connection_(connection) {
  for (std::size_t k = 0; k < kFiles.size(); ++k) opened_[k] = now(kFiles[k]);
}

/// The log of a database that is named by a link stands beside the database.
std::string Place::name(const char* suffix) const {
  if (*suffix == '\0') return connection_.file().string();
  return std::string(sqlite3_db_filename(connection_.handle(), "main")) + suffix;
}

std::optional<Place::File> Place::now(const char* suffix) const {
  struct stat found = {};
  if (::stat(name(suffix).c_str(), &found) != 0) return std::nullopt;
  return File{found.st_dev, found.st_ino};
}

/// The first of the three that is not what it was; empty: none.
std::string Place::what_has_changed() const {
  int moved = 0;  // since it was opened, which may be long before this was made
  sqlite3_file_control(connection_.handle(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  for (std::size_t k = 0; k < kFiles.size(); ++k) {
    const auto found = now(kFiles[k]);
    if (found && found == opened_[k] && (k > 0 || moved == 0)) continue;
    return name(kFiles[k]) + (found ? " is another file now" : " is not there any more");
  }
  return "";
}

void Place::leave() {
  struct stat log = {};
  const bool same_file = now("") == opened_[0];
  const bool others_log = same_file && now("-wal") != opened_[1] &&
                          ::stat(name("-wal").c_str(), &log) == 0 && log.st_size > 0;
  if (others_log) {
    sqlite3_db_config(connection_.handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  } else {
    sqlite3_wal_checkpoint_v2(connection_.handle(), "main", SQLITE_CHECKPOINT_TRUNCATE, nullptr,
                              nullptr);
  }
  guard_reads(connection_);
}

void Place::require_same() {
  const std::string changed = what_has_changed();
  if (changed.empty()) return;
  leave();
  throw StoreError({.what = "the database is no longer the one that was opened",
                    .where = {.file = connection_.file().string()},
                    .got = changed,
                    .expected = "nobody moves, removes or restores it while it is written",
                    .hint = "put the file that was opened back in its place, without the -wal and "
                            "-shm of another"});
}

void checkpoint(Connection& connection) {
  sqlite3_wal_checkpoint_v2(connection.handle(), "main", SQLITE_CHECKPOINT_PASSIVE, nullptr,
                            nullptr);
}

}  // namespace trammel::store
