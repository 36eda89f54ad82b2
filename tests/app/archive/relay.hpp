#pragma once
// Stands between a client and its server, and breaks what it is asked to break.

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/support/temporary.hpp"

namespace trammel::tests {

/// When the connection is cut, on both sides at once.
struct Cut {
  enum class What { never, client_messages, client_bytes, server_bytes } what = What::never;
  long after = 0;              // so many of them have gone through
  bool lie_of_commit = false;  // COMMIT is answered here, and the server never sees it
  std::string version = {};    // the server's, as two digits: what it then calls itself
};

/// PostgreSQL's protocol (version 3, no TLS) on a socket of its own.
class Relay {
 public:
  Relay(std::filesystem::path server_folder, int port, Cut cut);
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  [[nodiscard]] std::string uri(const std::string& database, const std::string& role) const;
  /// Of the client, gone through so far.
  [[nodiscard]] long messages() const { return n_messages_; }
  [[nodiscard]] long bytes() const { return n_bytes_; }
  [[nodiscard]] bool has_cut() const { return has_cut_; }

 private:
  void serve();
  void talk(int client, int server);
  TemporaryFolder folder_;
  std::filesystem::path server_folder_;
  int port_;
  Cut cut_;
  int listener_ = -1;
  std::atomic<long> n_messages_ = 0, n_bytes_ = 0;
  std::atomic<bool> has_cut_ = false, ended_ = false;
  std::thread thread_;
};

}  // namespace trammel::tests
