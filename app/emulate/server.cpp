#include "app/emulate/server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "app/device/tcp.hpp"
#include "core/error.hpp"

namespace trammel::emulate {

using Steady = std::chrono::steady_clock;

/// A client as the loop keeps it.
struct Connection {
  int socket = -1;
  std::unique_ptr<Conversation> conversation;
  std::string unsent = {};
  bool closing = false;  // once everything is sent
  bool gone = false;
  struct Due {
    Steady::time_point at;
    Answer answer;
  };
  std::vector<Due> due = {};  // by time, those of one time as they came
};

namespace {

constexpr std::size_t kMaxUnsent = 1 << 16;  // then the client is not read from
constexpr std::size_t kMaxDue = 64;          // nor with so many answers still to come

sockaddr_in address_of(const ServerOptions& options) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(options.port));
  if (options.port < 0 || options.port > 65535 ||
      inet_pton(AF_INET, options.address.c_str(), &address.sin_addr) != 1) {
    throw UsageError({.what = "no address to listen on",
                      .got = options.address + ":" + std::to_string(options.port),
                      .expected = "four numbers with dots, and a port from 0 to 65535"});
  }
  return address;
}

int listen_on(const ServerOptions& options) {
  const sockaddr_in address = address_of(options);
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int yes = 1;
  ::setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (listener < 0 ||
      ::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener, SOMAXCONN) != 0) {
    const std::string why = std::strerror(errno);
    if (listener >= 0) ::close(listener);
    throw DeviceError(
        {.what = "cannot listen on " + options.address + ":" + std::to_string(options.port),
         .got = why,
         .hint = "--port 0 takes any free port; ports below 1024 need rights"});
  }
  return listener;
}

int port_of(int socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

/// FIN would look like a server that has finished; a reset is a refusal.
void refuse(int socket) {
  const linger now{.l_onoff = 1, .l_linger = 0};
  ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &now, sizeof now);
  ::close(socket);
}

void send_some(Connection& c) {
  while (!c.unsent.empty()) {
    const ssize_t n = ::send(c.socket, c.unsent.data(), c.unsent.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      c.gone = errno != EAGAIN && errno != EWOULDBLOCK;
      return;
    }
    c.unsent.erase(0, static_cast<std::size_t>(n));
  }
  if (c.closing) c.gone = true;
}

void say_what_is_due(Connection& c) {
  const auto now = Steady::now();
  while (!c.due.empty() && c.due.front().at <= now && !c.closing) {
    const Answer answer = std::move(c.due.front().answer);
    c.due.erase(c.due.begin());
    c.unsent += answer.finish ? answer.finish() : answer.bytes;
    c.closing = answer.close;
  }
  send_some(c);
}

void receive_some(Connection& c) {
  char buffer[4096];
  const ssize_t n = ::recv(c.socket, buffer, sizeof buffer, 0);
  if (n == 0) c.gone = true;
  if (n < 0) c.gone = errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR;
  if (n <= 0) return;
  for (Answer& answer : c.conversation->receive({buffer, static_cast<std::size_t>(n)})) {
    const auto at = device::in_s(answer.after.count());
    const auto before = std::upper_bound(
        c.due.begin(), c.due.end(), at,
        [](Steady::time_point time, const Connection::Due& other) { return time < other.at; });
    c.due.insert(before, {at, std::move(answer)});
  }
}

}  // namespace

class Server::Loop {
 public:
  Loop(int listener, int wake, ServerOptions options, Make make)
      : listener_(listener), wake_(wake), options_(std::move(options)), make_(std::move(make)) {}
  ~Loop() {
    for (const Connection& c : connections_) ::close(c.socket);
  }

  void run() {
    for (;;) {
      std::vector<pollfd> watched = {{wake_, POLLIN, 0}, {listener_, POLLIN, 0}};
      for (const Connection& c : connections_) {
        const bool reads = c.unsent.size() < kMaxUnsent && c.due.size() < kMaxDue && !c.closing;
        const int in = reads ? POLLIN : 0;
        const int out = c.unsent.empty() ? 0 : POLLOUT;
        watched.push_back({c.socket, static_cast<short>(in | out), 0});
      }
      const int ready = ::poll(watched.data(), watched.size(), wait_ms());
      if (ready < 0 && errno != EINTR) return;
      if (watched[0].revents != 0) return;
      for (std::size_t k = 0; k < connections_.size(); ++k) {
        if ((watched[k + 2].revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
          receive_some(connections_[k]);
        }
        say_what_is_due(connections_[k]);
      }
      close_those_gone();  // first, so that a handle freed is there for who comes next
      if (watched[1].revents != 0) admit();
    }
  }

 private:
  [[nodiscard]] int wait_ms() const {
    auto first = Steady::time_point::max();
    for (const Connection& c : connections_) {
      if (!c.due.empty()) first = std::min(first, c.due.front().at);
    }
    if (const auto next_s = options_.meanwhile ? options_.meanwhile() : std::nullopt) {
      const auto wait =
          std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(*next_s));
      first = std::min(first, Steady::now() + wait);
    }
    if (first == Steady::time_point::max()) return -1;
    const double ms = std::chrono::duration<double, std::milli>(first - Steady::now()).count();
    return static_cast<int>(std::clamp(std::ceil(ms), 0.0, 60'000.0));
  }

  void close_those_gone() {
    std::erase_if(connections_, [](Connection& c) {
      if (!c.gone) return false;
      c.conversation.reset();  // frees its handle before the client can see that it is gone
      ::close(c.socket);
      return true;
    });
  }

  void admit() {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const int socket = ::accept4(listener_, reinterpret_cast<sockaddr*>(&from), &size,
                                 SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    if (connections_.size() >= options_.max_connections) return refuse(socket);
    const int yes = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    char text[INET_ADDRSTRLEN] = {};
    inet_ntop(AF_INET, &from.sin_addr, text, sizeof text);
    connections_.push_back({.socket = socket, .conversation = make_({text, ntohs(from.sin_port)})});
  }

  int listener_, wake_;
  ServerOptions options_;
  Make make_;
  std::vector<Connection> connections_;
};

Server::Server(const ServerOptions& options, Make make) : listener_(listen_on(options)) {
  port_ = port_of(listener_);
  wake_ = ::eventfd(0, EFD_CLOEXEC);
  thread_ = std::thread(
      [this, options, made = std::move(make)] { Loop(listener_, wake_, options, made).run(); });
}

Server::~Server() {
  const std::uint64_t one = 1;
  while (::write(wake_, &one, sizeof one) < 0 && errno == EINTR) {
  }
  thread_.join();
  ::close(wake_);
  ::close(listener_);
}

std::vector<LineReader::Line> LineReader::add(std::string_view bytes) {
  std::vector<Line> lines;
  for (const char c : bytes) {
    if (c == end_) {
      lines.push_back(std::exchange(open_, {}));
    } else if (c == '\r' || c == '\n') {
      continue;
    } else if (open_.text.size() == max_bytes_) {
      open_.too_long = true;
    } else {
      open_.text += c;
    }
  }
  return lines;
}

}  // namespace trammel::emulate
