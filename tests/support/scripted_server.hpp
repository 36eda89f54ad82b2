#pragma once
// A device that answers lines as a table says: over a real socket, in a thread of its own.

#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace trammel::tests {

/// What the server does with a line.
struct Answer {
  std::string bytes = {};  // may be half an answer, or nothing
  bool close = false;      // then ends the connection
  double delay_s = 0;      // before it answers
  bool usual = false;      // as if nothing had been said of this line
};
inline const Answer kUsual{"", false, 0, true};

/// Listens on a free port of 127.0.0.1, for any number of connections.
class ScriptedServer {
 public:
  /// Lines end with `end` ("\r", "\r\n").
  explicit ScriptedServer(std::string end);
  ~ScriptedServer();
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;

  /// To `line`: the answers one after the other, then the last one for ever. Replaces what was
  /// said of this line before. A line that nobody spoke of is answered by `otherwise`.
  void on(const std::string& line, std::vector<Answer> answers);
  void on(const std::string& line, const std::string& bytes) { on(line, {Answer{bytes}}); }
  /// Forgets what was said of a line.
  void forget(const std::string& line);
  /// Runs in the server's thread.
  void otherwise(std::function<std::string(const std::string& line)> answer);
  /// Refuses connections from now on, and ends the one that is there.
  void vanish();

  [[nodiscard]] int port() const { return port_; }
  /// All lines so far.
  [[nodiscard]] std::vector<std::string> lines() const;
  [[nodiscard]] int count(const std::string& line) const;
  [[nodiscard]] int connections() const { return connections_; }
  /// Waits until no connection is left.
  void await_none() const;

 private:
  void serve();
  void talk(int socket);
  Answer answer_to(const std::string& line);

  std::string end_;
  int listener_ = -1;
  int port_ = 0;
  int wake_[2] = {-1, -1};
  std::atomic<int> connections_ = 0;
  mutable std::mutex mutex_;
  std::map<std::string, std::deque<Answer>> answers_;
  std::function<std::string(const std::string&)> otherwise_;
  std::vector<std::string> lines_;
  std::vector<std::thread> talks_;
  std::atomic<int> open_ = 0;
  std::thread thread_;
};

}  // namespace trammel::tests
