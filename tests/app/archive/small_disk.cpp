#include "tests/app/archive/small_disk.hpp"

#include <sched.h>
#include <sys/mount.h>
#include <sys/statvfs.h>

#include <stdexcept>
#include <string>

namespace trammel::tests {

SmallDisk::SmallDisk(std::filesystem::path folder, uid_t owner) : folder_(std::move(folder)) {
  std::filesystem::create_directory(folder_);
  const std::string options = "size=1g,mode=700,uid=" + std::to_string(owner);
  if (unshare(CLONE_NEWNS) != 0 ||
      mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("tmpfs", folder_.c_str(), "tmpfs", 0, options.c_str()) != 0) {
    throw std::runtime_error("no small disk");
  }
}

SmallDisk::~SmallDisk() { umount2(folder_.c_str(), MNT_DETACH); }

void SmallDisk::leave_kb(long room) const {
  struct statvfs now {};
  if (statvfs(folder_.c_str(), &now) != 0) throw std::runtime_error("no small disk");
  const auto used = static_cast<long>((now.f_blocks - now.f_bfree) * now.f_frsize / 1024);
  const std::string size = "size=" + std::to_string(used + room) + "k";
  if (mount(nullptr, folder_.c_str(), nullptr, MS_REMOUNT, size.c_str()) != 0) {
    throw std::runtime_error("the disk keeps its size");
  }
}

}  // namespace trammel::tests
