#pragma once
// A client on loopback: raw bytes, a deadline on every wait.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

namespace trammel::tests {

class Client {
 public:
  explicit Client(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int yes = 1;
    ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
      throw std::runtime_error("no server on port " + std::to_string(port));
    }
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// A peer that has gone is seen by closed().
  void send(std::string_view bytes) {
    while (!bytes.empty() && !closed_) {
      const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      closed_ = n < 0;
      if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }

  /// Bytes until `enough`, the peer closes, or the patience is over; what has come.
  template <class Enough>
  std::string receive(Enough enough, int patience_ms = 5000) {
    std::string got;
    while (!closed_ && !enough(got)) {
      pollfd ready{socket_, POLLIN, 0};
      if (::poll(&ready, 1, patience_ms) <= 0) return got;
      char buffer[4096];
      const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
      if (n <= 0) {
        closed_ = true;
        return got;
      }
      got.append(buffer, static_cast<std::size_t>(n));
    }
    return got;
  }

  /// A line to a Galil; its answer up to the last of `n` prompts.
  std::string galil(const std::string& command, std::ptrdiff_t n = 1) {
    send(command + "\r");
    return receive([n](const std::string& got) {
      return std::count_if(got.begin(), got.end(), [](char c) { return c == ':' || c == '?'; }) >=
             n;
    });
  }
  /// A line to a tracker; its answer, up to the end of the line.
  std::string tracker(const std::string& command) {
    send(command + "\r\n");
    return receive([](const std::string& got) { return got.ends_with('\n'); });
  }
  /// The number that a Galil answers.
  double number(const std::string& command) { return std::stod(galil(command)); }
  /// Waits until these axes no longer move: the operand is polled, as a driver does.
  void until_at_rest(const std::string& axes = "ABC") {
    for (const char axis : axes) {
      const std::string name(1, axis);
      while (number("MG _BG" + name) != 0 || number("TE" + name) != 0) {
      }
    }
  }
  [[nodiscard]] bool closed() const { return closed_; }

 private:
  int socket_;
  bool closed_ = false;
};

}  // namespace trammel::tests
