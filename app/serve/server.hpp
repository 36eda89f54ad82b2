#pragma once
// The live page: a campaign's report with the state of its session, for a browser on this machine.

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

namespace trammel::serve {

struct Options {
  std::filesystem::path database;
  std::string campaign;      // name or uuid
  std::string session = {};  // empty: the one with the latest event
  int port = 0;              // 0: any that is free
  // With a client that is slow to ask, or to read: it holds up nobody, and one that asks while a
  // page is being made has to wait for that.
  std::chrono::milliseconds patience{30'000};
  // Connections of which no request has come whole: a browser opens six, and every process may
  // have 1024 handles.
  std::size_t most_waiting = 64;
};

/// Answers on 127.0.0.1 alone, under a path that holds a random token: who does not know it,
/// another user of the machine or a page of another site, gets 404. Nothing can be changed: only
/// GET is answered, and every answer opens the database read-only anew. The runner is another
/// process and notices nothing.
///
///   /TOKEN/             the page
///   /TOKEN/status.json  how the session is doing (session/status.hpp)
///   /TOKEN/page.json    "trammel/report-page/1" as it is now
///
/// Proof: server_test.cpp, and a browser that watches a campaign being measured (page_test.mjs).
class Server {
 public:
  /// Throws NotFoundError for a campaign or session that is not there, Error (exit 7) where the
  /// port is taken.
  explicit Server(Options options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// http://127.0.0.1:PORT/TOKEN/
  [[nodiscard]] std::string url() const;

  /// Ends the answering; from any thread.
  void stop();

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace trammel::serve
