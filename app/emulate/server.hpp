#pragma once
// A small TCP server over poll(2): bytes in, bytes out, for a handful of connections.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace trammel::emulate {

/// What a connection has to say. An answer may take its time: `finish` is called when it is due and
/// gives the bytes. Answers leave in the order of their due times.
struct Answer {
  std::string bytes = {};
  std::chrono::duration<double> after = std::chrono::duration<double>::zero();
  std::function<std::string()> finish = {};
  bool close = false;  // after what was sent before
};

/// One client. Made when it connects, destroyed when either side has closed.
class Conversation {
 public:
  virtual ~Conversation() = default;
  virtual std::vector<Answer> receive(std::string_view bytes) = 0;
};

struct Peer {
  std::string address;
  int port = 0;
};

struct ServerOptions {
  std::string address = "127.0.0.1";
  int port = 0;  // 0: any that is free
  std::size_t max_connections = 8;
  /// Called between packets, in the server's thread: what goes on without anybody asking. Seconds
  /// until it must be called again; nothing where it need not be before the next packet.
  std::function<std::optional<double>()> meanwhile = {};
};

/// Serves from its own thread, from construction to destruction. Conversations are made, used and
/// destroyed in that thread. A connection too many is reset at once; a client that does not read is
/// not read from.
class Server {
 public:
  using Make = std::function<std::unique_ptr<Conversation>(const Peer&)>;

  /// Throws DeviceError when the address cannot be listened on, saying which.
  Server(const ServerOptions& options, Make make);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] int port() const { return port_; }

 private:
  class Loop;
  int listener_ = -1;
  int wake_ = -1;
  int port_ = 0;
  std::thread thread_;
};

/// The lines a client sends, whole, however they were cut into packets: ended by `end` ("\r" or
/// "\n"), the other of the two ignored around it.
class LineReader {
 public:
  LineReader(char end, std::size_t max_bytes) : end_(end), max_bytes_(max_bytes) {}

  struct Line {
    std::string text;       // the first bytes of it when too long
    bool too_long = false;  // more than max_bytes
  };
  std::vector<Line> add(std::string_view bytes);

 private:
  char end_;
  std::size_t max_bytes_;
  Line open_;
};

}  // namespace trammel::emulate
