#pragma once
// A disk that is watched, and that can fail: an SQLite VFS over the real one.

#include <cstdint>
#include <functional>
#include <string>

namespace trammel::test {

struct DiskOperation {
  enum class Kind { open, read, write, truncate, sync, names, remove, map, lock };
  Kind kind = Kind::write;  // names: the folder of `file` is synced, what it holds by which name
  std::string file;         // full path
  std::int64_t offset = 0;  // of a write; the new size of a truncate
  std::string bytes = {};   // of a write
};

/// Asked before each operation of SQLite, and after each write and sync of a side file. SQLITE_OK
/// lets it through to the real disk; any other code is what SQLite gets in its place.
using DiskHook = std::function<int(const DiskOperation&)>;

/// While it lives, every database opened in this process is on the watched disk; one at a time.
/// Connections opened under it must be closed before it goes.
class WatchedDisk {
 public:
  explicit WatchedDisk(DiskHook hook);
  ~WatchedDisk();
  WatchedDisk(const WatchedDisk&) = delete;
  WatchedDisk& operator=(const WatchedDisk&) = delete;
};

/// While it lives, SQLite's n-th allocation from now on fails (from 1), and all later ones where
/// `for_good`. No connection may be open when it comes and when it goes.
class ScarceMemory {
 public:
  ScarceMemory(std::int64_t nth, bool for_good);
  ~ScarceMemory();
  ScarceMemory(const ScarceMemory&) = delete;
  ScarceMemory& operator=(const ScarceMemory&) = delete;
  /// Allocations asked for so far.
  [[nodiscard]] static std::int64_t asked();
};

}  // namespace trammel::test
