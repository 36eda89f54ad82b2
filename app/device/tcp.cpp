#include "app/device/tcp.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

namespace trammel::device {

namespace {

constexpr std::size_t kReceiveBytes = 4096;

/// For poll(2): rounded up, so that a wait never ends before its deadline.
int milliseconds_until(Deadline deadline) {
  using namespace std::chrono;
  const auto left = ceil<milliseconds>(deadline - steady_clock::now()).count();
  return static_cast<int>(std::clamp<long long>(left, 0, 1'000'000));
}

struct FreeAddresses {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};

std::unique_ptr<addrinfo, FreeAddresses> addresses_of(const Endpoint& to) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const int error = ::getaddrinfo(to.host.c_str(), std::to_string(to.port).c_str(), &hints, &list);
  if (error == 0) return std::unique_ptr<addrinfo, FreeAddresses>(list);
  throw LinkError(LinkError::Kind::no_connection, {.what = "the device's host has no address",
                                                   .got = to.text() + ", " + ::gai_strerror(error),
                                                   .hint = "check `host` and the network"});
}

/// 0, or why this address does not answer. `socket_fd` is open, and non-blocking, on success alone.
int connect_to(const addrinfo& address, Deadline deadline, int& socket_fd) {
  socket_fd = ::socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_fd < 0) return errno;
  int error = ::connect(socket_fd, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  if (error == EINPROGRESS || error == EINTR) {
    pollfd wait{socket_fd, POLLOUT, 0};
    int ready = 0;
    do {
      ready = ::poll(&wait, 1, milliseconds_until(deadline));
    } while (ready < 0 && errno == EINTR);
    socklen_t size = sizeof error;
    if (ready > 0) {
      ::getsockopt(socket_fd, SOL_SOCKET, SO_ERROR, &error, &size);
    } else {
      error = ready == 0 ? ETIMEDOUT : errno;
    }
  }
  if (error == 0) {
    const int on = 1;  // a question is one small packet; do not wait for more
    ::setsockopt(socket_fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return 0;
  }
  ::close(socket_fd);
  socket_fd = -1;
  return error;
}

}  // namespace

Deadline in_s(double seconds) {
  using namespace std::chrono;
  constexpr double kMostS = 1e9;
  const duration<double> away(std::clamp(seconds, -kMostS, kMostS));
  return steady_clock::now() + duration_cast<steady_clock::duration>(away);
}

TcpLink::TcpLink(Endpoint to, Deadline deadline) : to_(std::move(to)) {
  int error = 0;
  const auto list = addresses_of(to_);
  for (const addrinfo* address = list.get(); address != nullptr; address = address->ai_next) {
    error = connect_to(*address, deadline, socket_);
    if (error == 0) return;
  }
  throw LinkError(LinkError::Kind::no_connection,
                  {.what = "no connection to the device",
                   .got = to_.text() + ", " + std::strerror(error),
                   .hint = "check power, cable, `host` and `port`"});
}

void TcpLink::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

void TcpLink::lose(LinkError::Kind kind, const std::string& what) {
  close();
  throw LinkError(kind, {.what = what, .got = to_.text()});
}

void TcpLink::await(short events, Deadline deadline, const char* what) {
  if (socket_ < 0) lose(LinkError::Kind::closed, "the connection is closed");
  pollfd wait{socket_, events, 0};
  int ready = 0;
  do {
    ready = ::poll(&wait, 1, milliseconds_until(deadline));
  } while (ready < 0 && errno == EINTR);
  if (ready == 0) lose(LinkError::Kind::silent, what);
  if (ready < 0) lose(LinkError::Kind::closed, std::strerror(errno));
}

void TcpLink::send(std::string_view bytes, Deadline deadline) {
  while (!bytes.empty()) {
    await(POLLOUT, deadline, "the device takes nothing in time");
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    if (sent < 0 && errno != EINTR && errno != EAGAIN) {
      lose(LinkError::Kind::closed, std::string("the connection broke: ") + std::strerror(errno));
    }
  }
}

std::string TcpLink::receive(Deadline deadline) {
  std::array<char, kReceiveBytes> buffer;
  for (;;) {
    await(POLLIN, deadline, "no answer in time");
    const ssize_t got = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (got > 0) return {buffer.data(), static_cast<std::size_t>(got)};
    if (got == 0) lose(LinkError::Kind::closed, "the device closed the connection");
    if (errno != EINTR && errno != EAGAIN) {
      lose(LinkError::Kind::closed, std::string("the connection broke: ") + std::strerror(errno));
    }
  }
}

std::string TcpLink::pending() {
  if (socket_ < 0) lose(LinkError::Kind::closed, "the connection is closed");
  pollfd wait{socket_, POLLIN, 0};
  return ::poll(&wait, 1, 0) > 0 ? receive(in_s(0)) : std::string();
}

}  // namespace trammel::device
