#pragma once
// One TCP line to a device: bytes out, bytes in, and a deadline on everything.

#include <chrono>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace trammel::device {

using Deadline = std::chrono::steady_clock::time_point;
/// So many seconds from now; thirty years where it is more, which the clock can still count.
Deadline in_s(double seconds);

struct Endpoint {
  std::string host;
  int port = 0;
  [[nodiscard]] std::string text() const { return host + ":" + std::to_string(port); }
};

/// The line is gone, or out of step. What the device did with the last thing sent is unknown: who
/// catches this must ask it, on a new connection.
struct LinkError : DeviceError {
  enum class Kind {
    no_connection,  // refused, unreachable, or not in time
    closed,         // the other side ended it
    silent,         // no answer in time, or half of one
    out_of_step,    // an answer that nobody asked for: that to another question, or twice
    nonsense,       // an answer of no known form
  };
  LinkError(Kind why, ErrorText text) : DeviceError(std::move(text)), kind(why) {}
  Kind kind;
};

/// A connected socket. Whatever throws leaves it closed: after a lost answer nothing that still
/// comes can be told from the answer to the next question. Never raises SIGPIPE; goes on after a
/// signal with the time that is left. Proof: tcp_test.cpp.
class TcpLink {
 public:
  /// Throws LinkError.
  TcpLink(Endpoint to, Deadline deadline);
  ~TcpLink() { close(); }
  TcpLink(const TcpLink&) = delete;
  TcpLink& operator=(const TcpLink&) = delete;

  /// Sends all of it. Throws LinkError.
  void send(std::string_view bytes, Deadline deadline);
  /// At least one byte. Throws LinkError.
  std::string receive(Deadline deadline);
  /// What is there already, possibly nothing. Throws LinkError when the other side has closed.
  std::string pending();
  void close();
  [[nodiscard]] const Endpoint& endpoint() const { return to_; }

 private:
  void await(short events, Deadline deadline, const char* what);
  [[noreturn]] void lose(LinkError::Kind kind, const std::string& what);

  Endpoint to_;
  int socket_ = -1;
};

}  // namespace trammel::device
