// What other processes, a death and a folder without permission do to a database.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <set>
#include <thread>

#include "core/statistics/random.hpp"
#include "store/transaction.hpp"
#include "store/verify.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/skip.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::number;
using trammel::test::TempFolder;

namespace {

// Runs `work` in a process of its own; its exit code is what `work` returns, 99 for an exception.
template <class Work>
pid_t child(Work work) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  int code = 99;
  try {
    code = work();
  } catch (const Error& error) {
    code = static_cast<int>(error.code());
  } catch (...) {
  }
  _exit(code);
}

int exit_code(pid_t pid) {
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

// Measures what is left of the session, and says each point's seq into `pipe` once it is stored.
int record(const std::filesystem::path& file, Id session, int pipe) {
  Connection db = store::open(file, Access::write);
  interrupt_open_attempts(db, session, "the runner died");
  const Epoch epoch = open_epoch(db, session, SetUp::fresh, "start or resume");
  for (const Point& point : open_points(db, session)) {
    const Id attempt = begin_attempt(db, session, point.seq, epoch.id);
    finish_attempt(db, attempt, {test::reading_at(point)});
    if (::write(pipe, &point.seq, sizeof point.seq) != sizeof point.seq) return 1;
  }
  return 0;
}

std::vector<int> acknowledged(int pipe) {
  std::vector<int> seqs;
  int seq = 0;
  while (::read(pipe, &seq, sizeof seq) == sizeof seq) seqs.push_back(seq);
  return seqs;
}

}  // namespace

TEST_CASE("two processes that write at once both store everything", "[store]") {
  const TempFolder folder;
  const auto file = folder.file("lab.db");
  constexpr int kPoints = 40;
  const auto work = [&](const std::string& name) {
    return child([&] {
      Connection db = store::open(file, Access::create);  // both may be the one that makes it
      const Id campaign = add_campaign(db, test::small_campaign(1, name));
      test::measured_session(db, campaign, "s", kPoints);
      return 0;
    });
  };
  const pid_t one = work("one");
  const pid_t two = work("two");
  CHECK(exit_code(one) == 0);
  CHECK(exit_code(two) == 0);
  Connection db = store::open(file, Access::read_only);
  CHECK(number(db, "SELECT count(*) FROM reading") == 2 * kPoints);
  CHECK(verify(db).findings.empty());
}

TEST_CASE("processes that make a database at once all store what they have", "[store]") {
  const TempFolder folder;
  constexpr int kRounds = 12, kProcesses = 4;
  for (int round = 0; round < kRounds; ++round) {
    const auto file = folder.file("lab" + std::to_string(round));
    int start[2];
    REQUIRE(pipe(start) == 0);
    std::vector<pid_t> all;
    for (int k = 0; k < kProcesses; ++k) {
      all.push_back(child([&] {
        close(start[1]);
        char byte = 0;
        if (read(start[0], &byte, 1) != 0) return 1;  // until all are there
        Connection db = store::open(file, Access::create);
        add_campaign(db, test::small_campaign(1, "c" + std::to_string(k)));
        return 0;
      }));
    }
    close(start[0]);
    close(start[1]);
    for (const pid_t pid : all) CHECK(exit_code(pid) == 0);
    Connection db = store::open(file, Access::read_only);
    CHECK(list_campaigns(db).size() == kProcesses);
  }
}

TEST_CASE("a runner killed at any moment loses no acknowledged point and repeats none", "[store]") {
  const TempFolder folder;
  const auto file = folder.file("lab.db");
  constexpr int kPoints = 300;
  Id session = 0;
  {
    Connection db = store::open(file, Access::create);
    const Id campaign = add_campaign(db, test::small_campaign());
    session = create_session(
        db, {.campaign_id = campaign, .name = "s", .points = test::line_plan(kPoints)});
  }
  Random random(20260131);
  std::set<int> told;
  int deaths = 0;
  int code = -1;
  for (int life = 0; life < 200 && code != 0; ++life) {
    int ends[2] = {};
    REQUIRE(pipe(ends) == 0);
    const pid_t runner = child([&] { return record(file, session, ends[1]); });
    close(ends[1]);
    if (life < 20) {
      std::this_thread::sleep_for(std::chrono::microseconds(2000 + random.below(30'000)));
      kill(runner, SIGKILL);
    }
    for (const int seq : acknowledged(ends[0])) CHECK(told.insert(seq).second);  // never twice
    close(ends[0]);
    code = exit_code(runner);
    if (code == -SIGKILL) ++deaths;
    Connection db = store::open(file, Access::read_only);
    std::set<int> stored;
    for (const Attempt& attempt : attempts(db, session)) {
      if (attempt.status == "ok") CHECK(stored.insert(attempt.point_seq).second);
    }
    CHECK(std::ranges::includes(stored, told));
    CHECK(verify(db).findings.empty());
  }
  CHECK(code == 0);
  CHECK(deaths > 0);  // else nothing was tried
  Connection db = store::open(file, Access::read_only);
  CHECK(number(db, "SELECT count(*) FROM reading") == kPoints);
  CHECK(get_session(db, session).n_ok == kPoints);
}

TEST_CASE("a folder without permission to write is read, and writing to it says why not",
          "[store]") {
  if (geteuid() != 0) {
    return tests::skip("only root can become somebody else");
  }
  const TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    Connection db = store::open(file, Access::create);
    import_campaign(db, test::small_campaign());
  }
  std::filesystem::permissions(file, std::filesystem::perms(0444));
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  const auto as_nobody = [&](auto work) {
    constexpr uid_t kNobody = 65534;
    return exit_code(child([&] { return setuid(kNobody) == 0 ? work() : 98; }));
  };
  CHECK(as_nobody([&] {
          Connection db = store::open(file, Access::read_only);
          return static_cast<int>(load_campaign(db, 1).campaign.readings.size());
        }) == 6);
  constexpr int kStorage = static_cast<int>(ExitCode::storage);
  CHECK(as_nobody([&] {
          Connection db = store::open(file, Access::write);
          add_campaign(db, test::small_campaign(1, "second"));
          return 0;
        }) == kStorage);
  CHECK(as_nobody([&] {
          store::open(folder.file("new.db"), Access::create);
          return 0;
        }) == kStorage);
}
