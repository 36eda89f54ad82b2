#include "app/session/lock.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <set>

#include "core/error.hpp"

namespace trammel::session {

namespace {

std::filesystem::path lock_file(const std::filesystem::path& database, const std::string& uuid) {
  return std::filesystem::weakly_canonical(database).string() + "." + uuid + ".lock";
}

int read_pid(int descriptor) {
  std::array<char, 24> text{};
  const ssize_t n = ::pread(descriptor, text.data(), text.size(), 0);
  int pid = 0;
  if (n > 0) std::from_chars(text.data(), text.data() + n, pid);
  return pid;
}

/// Numeric addresses of "host:port", each once; the text as it is where it has none: then nobody
/// can connect either.
std::set<std::string> addresses_of(const std::string& endpoint) {
  const std::size_t colon = endpoint.rfind(':');
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* list = nullptr;
  std::set<std::string> addresses;
  if (::getaddrinfo(endpoint.substr(0, colon).c_str(), nullptr, &hints, &list) == 0) {
    for (const addrinfo* at = list; at != nullptr; at = at->ai_next) {
      std::array<char, NI_MAXHOST> name{};
      if (::getnameinfo(at->ai_addr, at->ai_addrlen, name.data(), name.size(), nullptr, 0,
                        NI_NUMERICHOST) == 0) {
        addresses.insert(std::string(name.data()) + endpoint.substr(colon));
      }
    }
    ::freeaddrinfo(list);
  }
  if (addresses.empty()) addresses.insert(endpoint);
  return addresses;
}

/// An abstract name: it begins with a zero, and there is no file.
struct KernelName {
  explicit KernelName(const std::string& text) {
    address.sun_family = AF_UNIX;
    const std::string name = ("trammel controller " + text).substr(0, sizeof address.sun_path - 1);
    std::copy(name.begin(), name.end(), address.sun_path + 1);
    size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  }
  [[nodiscard]] const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address); }
  sockaddr_un address{};
  socklen_t size = 0;
};

int unix_socket() { return ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); }

/// The process that listens under a name.
std::string holder_of(const KernelName& name) {
  const int to = unix_socket();
  ucred peer{};
  socklen_t size = sizeof peer;
  const bool known = ::connect(to, name.get(), name.size) == 0 &&
                     ::getsockopt(to, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0;
  ::close(to);
  return known ? "process " + std::to_string(peer.pid) : "another process";
}

}  // namespace

ControllerLock::ControllerLock(const std::string& endpoint) {
  for (const std::string& address : addresses_of(endpoint)) {
    const KernelName name(address);
    const int held = unix_socket();
    if (held >= 0 && ::bind(held, name.get(), name.size) == 0 && ::listen(held, 8) == 0) {
      sockets_.push_back(held);
      continue;
    }
    const int error = errno;
    if (held >= 0) ::close(held);
    for (const int mine : sockets_) ::close(mine);
    if (error != EADDRINUSE) {
      throw Error(ExitCode::error, {.what = "the controller cannot be locked",
                                    .where = {.field = "controller"},
                                    .got = std::strerror(error)});
    }
    throw Error(ExitCode::error,
                {.what = "the controller at " + address + " is driven already",
                 .where = {.field = "controller"},
                 .got = holder_of(name),
                 .expected = "one runner per controller, whatever its database",
                 .hint = "see `trammel session status` with that runner's --db, or stop it"});
  }
}

ControllerLock::~ControllerLock() {
  for (const int held : sockets_) ::close(held);  // and with it the name
}

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
