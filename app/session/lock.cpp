#include "app/session/lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "core/error.hpp"

namespace trammel::session {

namespace {

std::filesystem::path lock_file(const std::filesystem::path& database, const std::string& uuid) {
  return database.string() + "." + uuid + ".lock";
}

int read_pid(int descriptor) {
  std::array<char, 24> text{};
  const ssize_t n = ::pread(descriptor, text.data(), text.size(), 0);
  int pid = 0;
  if (n > 0) std::from_chars(text.data(), text.data() + n, pid);
  return pid;
}

}  // namespace

CampaignLock::CampaignLock(const std::filesystem::path& database, const std::string& uuid) {
  const std::filesystem::path file = lock_file(database, uuid);
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ < 0) {
    throw StoreError({.what = "the campaign's lock file cannot be opened",
                      .where = {.file = file.string()},
                      .got = std::strerror(errno)});
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    const int pid = read_pid(descriptor_);
    ::close(descriptor_);
    throw Error(ExitCode::error, {.what = "the campaign is being measured already",
                                  .got = "process " + std::to_string(pid),
                                  .expected = "one runner per campaign",
                                  .hint = "see `trammel session status`, or stop it with "
                                          "`trammel session stop`"});
  }
  const std::string pid = std::to_string(::getpid()) + "\n";
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::pwrite(descriptor_, pid.data(), pid.size(), 0) != static_cast<ssize_t>(pid.size())) {
    ::close(descriptor_);
    throw StoreError({.what = "the campaign's lock file cannot be written",
                      .where = {.file = file.string()},
                      .got = std::strerror(errno)});
  }
}

CampaignLock::~CampaignLock() { ::close(descriptor_); }  // and with it the lock

std::optional<int> CampaignLock::holder(const std::filesystem::path& database,
                                        const std::string& uuid) {
  const int descriptor = ::open(lock_file(database, uuid).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return std::nullopt;
  std::optional<int> pid;
  if (::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    pid = read_pid(descriptor);
  }
  ::close(descriptor);
  return pid;
}

}  // namespace trammel::session
