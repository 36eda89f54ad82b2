// A full disk, another process's transaction, no network: the program in such surroundings.

#include <netinet/in.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "store/transaction.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

using namespace trammel;
using namespace trammel::test;
using tests::run_program;

namespace {

const std::string kRobot = "sim:" + tests::source_folder() + "/examples/paper/robot.json";

/// Runs `work` in a process with namespaces of its own; its exit code, or -1 where that is not
/// allowed.
template <class Work>
int apart(int namespaces, Work work) {
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(namespaces) != 0) _exit(120);
    int code = 99;
    try {
      code = work();
    } catch (...) {
    }
    _exit(code);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 98;
  return code == 120 ? -1 : code;
}

bool can_connect(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  const bool connected =
      ::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  ::close(socket);
  return connected;
}

}  // namespace

TEST_CASE("a full disk is said with exit code 8, and with room the session goes on", "[stress]") {
  const TempFolder folder;
  const std::string mounted = folder.path() / "small";
  std::filesystem::create_directory(mounted);
  const int code = apart(CLONE_NEWNS, [&] {
    if (mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("tmpfs", mounted.c_str(), "tmpfs", 0, "size=700k") != 0) {
      return 121;
    }
    const std::string db = mounted + "/lab.db";
    const auto full =
        run_program({"session", "run", "c", "--plan", "paper-80", "--stage", kRobot, "--db", db},
                    folder.path());
    if (full.exit_code != 8 || full.err.find("the disk is full") == std::string::npos) return 1;
    if (mount(nullptr, mounted.c_str(), nullptr, MS_REMOUNT, "size=20m") != 0) return 121;
    const auto first =
        run_program({"query", "SELECT count(*) FROM reading", "--csv", "--db", db}, folder.path());
    const auto rest =
        run_program({"session", "resume", "c", "--session", "paper-80", "--db", db}, folder.path());
    const auto check = run_program({"db", "verify", "--db", db}, folder.path());
    if (first.exit_code != 0) return 2;
    if (rest.exit_code != 0) return 3;
    return check.exit_code == 0 ? 0 : 4;
  });
  if (code == -1 || code == 121) {
    tests::skip("a small disk needs the right to mount one");
    return;
  }
  CHECK(code == 0);
}

TEST_CASE("a command waits for another process's transaction, and then does its work", "[stress]") {
  const TempFolder folder;
  store::Connection db = store::open(folder.file("lab.db"), store::Access::create);
  store::import_campaign(db, small_campaign());
  tests::Finished finished;
  std::thread other;
  {
    const store::Transaction transaction(db);
    other = std::thread([&] {
      finished = run_program({"reading", "exclude", "rail-test", "--seq", "2", "--reason", "bumped",
                              "--db", folder.file("lab.db").string()},
                             folder.path());
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    CHECK(store::exclusions(db, 1).empty());
  }
  other.join();
  CHECK(finished.exit_code == 0);
  CHECK(store::exclusions(db, 1).size() == 1);
}

TEST_CASE("without a network a campaign is measured, calibrated and reported", "[stress]") {
  const TempFolder folder;
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  REQUIRE(::bind(listener, reinterpret_cast<sockaddr*>(&address), size) == 0);
  REQUIRE(::listen(listener, 1) == 0);
  REQUIRE(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  const std::uint16_t port = ntohs(address.sin_port);
  CHECK(can_connect(port));
  const int code = apart(CLONE_NEWNET, [&] {
    if (can_connect(port)) return 1;  // the control: there is no network in here
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"session", "run", "c", "--plan", "paper-80", "--stage", kRobot},
          {"calibrate", "idw", "c"},
          {"report", "c"}}) {
      if (run_program(words, folder.path()).exit_code != 0) return 2;
    }
    return 0;
  });
  ::close(listener);
  if (code == -1) {
    tests::skip("a network of its own needs the right to make one");
    return;
  }
  CHECK(code == 0);
}
