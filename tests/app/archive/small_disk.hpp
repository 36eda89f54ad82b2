#pragma once
// A disk that can be full.

#include <sys/types.h>

#include <filesystem>

namespace trammel::tests {

/// A file system in memory at a new folder, seen by this process and those it starts, gone with it.
class SmallDisk {
 public:
  /// @throws std::runtime_error  nobody may mount one here
  SmallDisk(std::filesystem::path folder, uid_t owner);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  /// Leaves this much room from now on.
  void leave_kb(long room) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace trammel::tests
