#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "store/connection.hpp"

namespace trammel::store {

/// Whether a database that is being written is still the one that was opened: the identities
/// (device, inode) of its file, its log (-wal) and the log's index (-shm) under its name. SQLite
/// writes on into files that were removed, renamed or replaced, and whoever opens the name then
/// finds nothing, or another database under this log.
class Place {
 public:
  /// As it stands now. The connection must outlive it.
  explicit Place(Connection& connection);

  /// Throws StoreError where one of the three is not what it was. Before that, what the log holds
  /// is written into the file that was opened, wherever that is now, and the log is emptied: that
  /// file holds its data, and nothing lies over the one that took its name. Not where the same file
  /// has another log, which others may be using: theirs is left alone. From then on the connection
  /// writes nothing. Proof: place_test.cpp.
  void require_same();

 private:
  struct File {
    std::uint64_t device = 0;
    std::uint64_t number = 0;
    bool operator==(const File&) const = default;
  };
  static constexpr std::array<const char*, 3> kFiles = {"", "-wal", "-shm"};
  [[nodiscard]] std::string name(const char* suffix) const;
  [[nodiscard]] std::optional<File> now(const char* suffix) const;
  [[nodiscard]] std::string what_has_changed() const;
  void leave();

  Connection& connection_;
  std::array<std::optional<File>, kFiles.size()> opened_;
};

/// Moves what the log holds into the database's own file as far as readers allow, so that a copy of
/// that file alone holds the data. One that fails loses nothing: the log keeps it.
void checkpoint(Connection& connection);

}  // namespace trammel::store
