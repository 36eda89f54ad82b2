#include "tests/app/archive/postgres.hpp"

#include <pwd.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include "app/archive/install.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

namespace trammel::tests {

namespace {

/// Debian's are not on PATH.
std::string programs_of_postgres() {
  std::vector<std::string> found;
  std::error_code none;
  for (const auto& version : std::filesystem::directory_iterator("/usr/lib/postgresql", none)) {
    if (std::filesystem::exists(version.path() / "bin/initdb")) {
      found.push_back((version.path() / "bin").string());
    }
  }
  return found.empty() ? "" : *std::ranges::max_element(found);
}

/// The server's programs refuse to run as root.
Finished as_postgres(std::vector<std::string> words) {
  if (geteuid() == 0) {
    const std::vector<std::string> before = {"runuser", "-u", "postgres", "--"};
    words.insert(words.begin(), before.begin(), before.end());
  }
  Finished done = run_command(words, "/");
  if (done.exit_code != 0) throw std::runtime_error(words.back() + ": " + done.out + done.err);
  return done;
}

int own_port() { return 20000 + static_cast<int>(getpid()) % 20000; }

}  // namespace

Postgres* Postgres::shared() {
  static const std::string programs = programs_of_postgres();
  if (programs.empty()) {
    skip_without("postgresql");
    return nullptr;
  }
  static Postgres server(programs, own_port(), " -c fsync=off");
  return &server;
}

std::unique_ptr<Postgres> Postgres::durable(
    const std::function<void(const std::filesystem::path& folder)>& prepare,
    const std::string& settings) {
  const std::string programs = programs_of_postgres();
  if (programs.empty()) {
    skip_without("postgresql");
    return nullptr;
  }
  return std::unique_ptr<Postgres>(new Postgres(programs, own_port() + 20000, settings, prepare));
}

Postgres::Postgres(const std::string& programs, int port, std::string settings,
                   const std::function<void(const std::filesystem::path&)>& prepare)
    : programs_(programs), port_(port), settings_(std::move(settings)) {
  if (geteuid() == 0) {
    const passwd* user = getpwnam("postgres");
    if (user == nullptr || chown(folder_.path().c_str(), user->pw_uid, user->pw_gid) != 0) {
      throw std::runtime_error("no user postgres");
    }
  }
  if (prepare) prepare(folder_.path());
  as_postgres({programs_ + "/initdb", "-D", folder_.path() / "data", "-X", folder_.path() / "wal",
               "--wal-segsize=1", "-A", "trust", "-U", "postgres", "-N", "--no-instructions", "-E",
               "UTF8", "--locale=C.UTF-8"});
  start();
  archive::Link link({.uri = uri("postgres", "postgres"), .who = "tests"});
  link.run("CREATE ROLE owner LOGIN CREATEROLE");
  for (const char* group : {"trammel_station", "trammel_worker", "trammel_reader"}) {
    link.run(std::string("CREATE ROLE ") + group);
  }
  link.run(
      "CREATE ROLE robot_a LOGIN IN ROLE trammel_station; CREATE ROLE robot_b LOGIN IN ROLE "
      "trammel_station; CREATE ROLE worker LOGIN IN ROLE trammel_worker; CREATE ROLE visitor "
      "LOGIN IN ROLE trammel_reader; CREATE ROLE stranger LOGIN");
}

void Postgres::start() {
  const std::string settings = "-c listen_addresses=127.0.0.1 -c port=" + std::to_string(port_) +
                               " -c unix_socket_directories=" + folder_.path().string() +
                               " -c shared_buffers=32MB" + settings_;
  // A killed server's memory may be held for a moment by children that are not quite dead.
  for (int left = 20;; --left) {
    try {
      as_postgres({programs_ + "/pg_ctl", "start", "-w", "-D", folder_.path() / "data", "-l",
                   folder_.path() / "log", "-o", settings});
      return;
    } catch (const std::runtime_error&) {
      if (left == 0) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }
}

int Postgres::postmaster() const {
  std::ifstream file(folder_.path() / "data/postmaster.pid");
  pid_t found = 0;
  if (!(file >> found) || found <= 1) throw std::runtime_error("no server");
  return found;
}

double Postgres::processor_s() const {
  std::string stat = read_text("/proc/" + std::to_string(postmaster()) + "/stat");
  std::istringstream fields(stat.substr(stat.rfind(')') + 2));
  std::string skipped;
  for (int field = 3; field < 16; ++field) fields >> skipped;
  double user = 0, system = 0;  // of children, proc(5)
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void Postgres::kill() {
  const pid_t postmaster = this->postmaster();
  // Its children go with it when they find it gone; the first of all is that nobody starts more.
  ::kill(postmaster, SIGSTOP);
  std::ifstream children("/proc/" + std::to_string(postmaster) + "/task/" +
                         std::to_string(postmaster) + "/children");
  for (pid_t child = 0; children >> child;) ::kill(child, SIGKILL);
  ::kill(postmaster, SIGKILL);
  while (::kill(postmaster, 0) == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

Postgres::~Postgres() {
  try {
    as_postgres({programs_ + "/pg_ctl", "stop", "-m", "immediate", "-D", folder_.path() / "data"});
  } catch (const std::exception&) {  // it has stopped
  }
}

void Postgres::run(const std::string& program, std::vector<std::string> words) const {
  words.insert(words.begin(), {programs_ + "/" + program, "-h", folder_.path(), "-p",
                               std::to_string(port_), "-U", "postgres"});
  as_postgres(std::move(words));
}

std::string Postgres::uri(const std::string& database, const std::string& role) const {
  return "postgresql://" + role + "@/" + database + "?host=" + folder_.path().string() +
         "&port=" + std::to_string(port_);
}

std::string Postgres::new_archive() {
  const std::string name = "archive_" + std::to_string(++n_archives_);
  archive::Link(archive::LinkOptions{.uri = uri("postgres", "postgres"), .who = "tests"})
      .run("CREATE DATABASE " + name + " OWNER owner");
  archive::Link link({.uri = uri(name, "owner"), .who = "tests"});
  if (!archive::install(link)) throw std::runtime_error("an archive that is not new");
  return name;
}

}  // namespace trammel::tests
