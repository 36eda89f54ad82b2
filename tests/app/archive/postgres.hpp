#pragma once
// A PostgreSQL of the tests' own: on a socket in a temporary folder, gone with the process.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/archive/link.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::tests {

class Postgres {
 public:
  /// Started once a process. Nothing where PostgreSQL is not installed: the case is skipped.
  static Postgres* shared();
  /// Another one, with fsync, to be killed. `prepare` gets its folder, in which its data will be in
  /// `data` and its log of writes in `wal`; `settings` are the server's. Nothing where PostgreSQL
  /// is not installed.
  static std::unique_ptr<Postgres> durable(
      const std::function<void(const std::filesystem::path& folder)>& prepare = {},
      const std::string& settings = "");
  /// SIGKILL to every process of the server.
  void kill();
  /// What its connections that have ended took of the processor.
  [[nodiscard]] double processor_s() const;
  void start();
  ~Postgres();
  Postgres(const Postgres&) = delete;
  Postgres& operator=(const Postgres&) = delete;

  /// One of PostgreSQL's programs, on this server. @throws std::runtime_error  it failed
  void run(const std::string& program, std::vector<std::string> words) const;

  /// A new archive, empty. Its owner is "owner"; robot_a and robot_b are stations, visitor reads.
  std::string new_archive();
  /// By the socket, as this role.
  [[nodiscard]] std::string uri(const std::string& database, const std::string& role) const;
  [[nodiscard]] std::filesystem::path socket_folder() const { return folder_.path(); }
  [[nodiscard]] int port() const { return port_; }  // of 127.0.0.1 too, without TLS

 private:
  Postgres(const std::string& programs, int port, std::string settings,
           const std::function<void(const std::filesystem::path&)>& prepare = {});
  [[nodiscard]] int postmaster() const;
  TemporaryFolder folder_;
  std::string programs_;
  int port_ = 0;
  std::string settings_;
  int n_archives_ = 0;
};

}  // namespace trammel::tests
