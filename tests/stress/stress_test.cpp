// The safety of data in seconds: a part of what scripts/stress measures, each with its control.

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
#include "tests/stress/faults.hpp"
#include "tests/stress/kills.hpp"
#include "tests/stress/mutate.hpp"
#include "tests/stress/power_loss.hpp"
#include "tests/stress/recorder.hpp"
#include "tests/stress/soak.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

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

TEST_CASE("power lost at any operation loses no acknowledged point and corrupts nothing",
          "[stress]") {
  const TempFolder folder;
  const PowerLossCount count =
      lose_power(folder.path(), {.n_points = 6, .every = 4, .resume_every = 150});
  INFO(count.first_problem);
  CHECK(count.images > 300);
  CHECK(count.lost_images == 0);
  CHECK(count.corrupt == 0);
  CHECK(count.resumed > 0);
  CHECK(count.wrong_resumes == 0);
}

TEST_CASE("with synchronous=NORMAL or on a disk that lies power loss does lose points",
          "[stress]") {
  // The control: else the test above proved nothing.
  const TempFolder a, b;
  CHECK(lose_power(a.path(),
                   {.n_points = 6, .every = 9, .resume_every = 0, .durability = Durability::normal})
            .lost_images > 0);
  CHECK(lose_power(b.path(), {.n_points = 6, .every = 9, .resume_every = 0, .lies = true})
            .lost_images > 0);
}

TEST_CASE("an operation that fails once or for good loses nothing, and a lasting fault is reported",
          "[stress]") {
  struct Case {
    Fault fault;
    std::int64_t every;
  };
  for (const Case& c :
       {Case{Fault::io_error, 23}, Case{Fault::disk_full, 11}, Case{Fault::out_of_memory, 1999}}) {
    for (const bool for_good : {false, true}) {
      const TempFolder folder;
      const FaultCount count = sweep_faults(
          folder.path(), {.fault = c.fault, .for_good = for_good, .every = c.every, .n_points = 2});
      INFO("fault " << static_cast<int>(c.fault) << ", for good " << for_good << ": "
                    << count.first_problem);
      CHECK(count.runs > 5);
      CHECK(count.reported > 0);  // the control: faults do arrive
      CHECK(count.violations() == 0);
    }
  }
}

TEST_CASE("the sweep of faults sees what a recorder loses that looks at no answer", "[stress]") {
  const TempFolder folder;
  for (const bool for_good : {false, true}) {
    const FaultCount count = sweep_faults(
        folder.path(),
        {.fault = Fault::disk_full, .for_good = for_good, .recorder = careless_recorder()});
    CHECK(count.lost > 0);
    CHECK((count.unreported > 0) == for_good);
  }
}

TEST_CASE("killed again and again, the program loses and repeats no point it told of", "[stress]") {
  const TempFolder folder;
  const KillCount count = sweep_kills(folder.path(), {.kills = 12, .seed = 7});
  INFO(count.first_problem);
  CHECK(count.kills >= 12);
  CHECK(count.with_points > 0);
  CHECK(count.lost + count.corrupt + count.repeated + count.different == 0);
}

TEST_CASE("the sweep of kills sees a log that does not outlive one", "[stress]") {
  const TempFolder folder;
  CHECK(sweep_kills(folder.path(), {.kills = 30, .seed = 7, .loses_log = true}).lost > 0);
}

TEST_CASE("whichever line over a socket is dropped, the campaign becomes whole",
          "[stress][sockets]") {
  const WireCount count = sweep_wires(emulate::FaultKind::dropped, 23);
  INFO(count.first_problem);
  CHECK(count.runs > 5);
  CHECK(count.wrong == 0);
}

TEST_CASE(
    "a short soak over sockets loses, repeats and invents nothing, and finds the parameters of a "
    "calm run",
    "[stress][sockets]") {
  const SoakCount count = soak_over_sockets({.n_points = 80, .share = 0.25, .seed = 7});
  INFO(count.first_problem);
  CHECK(count.points == 80);
  CHECK(count.faults > 8);
  CHECK(count.failed_tries > 5);
  CHECK(count.lives > 2);
  CHECK(count.lost == 0);
  CHECK(count.early > 0);  // the control: who acknowledges too early is seen to lose
  CHECK(count.wrong == 0);
  CHECK(count.parameters > 10);
  CHECK(count.worst_sigma < 4.5);  // one false alarm in some 10,000 runs
}

TEST_CASE("mutated files and databases are refused or taken, and nothing else", "[stress]") {
  const TempFolder folder;
  for (const Importer& importer : importers(folder.path())) {
    const MutationCount count = mutate(importer, folder.path(), 20, 100, 3);
    INFO(importer.name << ": " << count.first_problem);
    CHECK(count.tried == 100);
    CHECK(count.refused > 10);  // the control: they are changed
    CHECK(count.crashes + count.hangs == 0);
  }
}

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
    WARN("skipped: a small disk needs the right to mount one");
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
    WARN("skipped: a network of its own needs the right to make one");
    return;
  }
  CHECK(code == 0);
}
