#include "tests/stress/kills.hpp"

#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <stdexcept>
#include <thread>
#include <vector>

#include "app/files/plan_json.hpp"
#include "core/statistics/random.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"
#include "store/session.hpp"
#include "store/verify.hpp"
#include "tests/app/session/socket_campaign.hpp"
#include "tests/stress/soak.hpp"
#include "tests/support/paths.hpp"

namespace trammel::test {

namespace {

constexpr int kPoints = 80;

std::vector<std::string> words_for(const std::string& file, bool begun) {
  if (begun) return {"session", "resume", "c", "--db", file, "--session", "paper-80"};
  return {"session",  "run",     "c",
          "--db",     file,      "--plan",
          "paper-80", "--stage", "sim:" + tests::source_folder() + "/examples/paper/robot.json"};
}

struct Life {
  bool killed = false;
  int exit_code = -1;
  int told = 0;  // "k/80" on its terminal
  std::string last_words = {};
};

/// The last k of "] k/80" in what the program drew.
int last_told(const std::string& text, int n_points) {
  const std::string of = "/" + std::to_string(n_points) + ",";
  const auto slash = text.rfind(of);
  if (slash == text.npos) return 0;
  const auto begin = text.find_last_not_of("0123456789", slash - 1);
  return std::stoi(text.substr(begin + 1, slash - begin - 1));
}

Life live(const std::vector<std::string>& words, double patience_s, int n_points = kPoints) {
  std::string program = tests::build_folder() + "/trammel";
  std::vector<char*> arguments = {program.data()};
  std::vector<std::string> copies = words;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child < 0) throw std::runtime_error("forkpty");
  if (child == 0) {
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  std::thread killer;
  if (patience_s > 0) {
    killer = std::thread([child, patience_s] {
      std::this_thread::sleep_for(std::chrono::duration<double>(patience_s));
      kill(child, SIGKILL);  // not yet waited for: the number is still its own
    });
  }
  std::string text;
  char buffer[4096];
  for (ssize_t n = 0; (n = read(terminal, buffer, sizeof buffer)) > 0;) {
    text.append(buffer, static_cast<std::size_t>(n));
  }
  if (killer.joinable()) killer.join();
  close(terminal);
  int status = 0;
  waitpid(child, &status, 0);
  return {.killed = WIFSIGNALED(status),
          .exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          .told = last_told(text, n_points),
          .last_words = text.substr(text.size() - std::min<std::size_t>(text.size(), 400))};
}

struct State {
  bool begun = false;
  bool verifies = true;
  std::map<int, std::vector<Reading>> by_point;
};

State state_of(const std::string& file, const std::string& name = "paper-80") {
  State state;
  if (!std::filesystem::exists(file)) return state;
  // As the next program does: an unfinished creation is made anew.
  store::Connection db = store::open(file, store::Access::create);
  state.verifies = store::verify(db).ok();
  const auto campaign = store::find_campaign(db, "c");
  const auto session = campaign ? store::find_session(db, campaign->id, name) : std::nullopt;
  if (!session) return state;
  state.begun = true;
  std::map<store::Id, int> seq_of;
  for (const store::Attempt& a : store::attempts(db, session->id)) {
    if (a.status == "ok") seq_of[a.id] = a.point_seq;
  }
  for (const store::StoredReading& r : store::readings(db, campaign->id, {session->id})) {
    state.by_point[seq_of.at(r.attempt_id.value())].push_back(r.data.reading);
  }
  return state;
}

bool same_bits(const Reading& a, const Reading& b) {
  return a.target == b.target && a.set == b.set && a.measured == b.measured &&
         a.conditions.cmd_mm == b.conditions.cmd_mm &&
         a.conditions.from_mm == b.conditions.from_mm &&
         a.conditions.time_s == b.conditions.time_s &&
         a.conditions.temp_degc == b.conditions.temp_degc;
}

}  // namespace

KillCount sweep_kills(const std::filesystem::path& folder, const KillOptions& options) {
  KillCount count;
  const std::string whole = folder / "whole.db";
  const auto began = std::chrono::steady_clock::now();
  if (live(words_for(whole, false), 0).exit_code != 0) throw std::runtime_error("not recorded");
  const std::chrono::duration<double> takes = std::chrono::steady_clock::now() - began;
  const State expected = state_of(whole);
  Random random(options.seed);
  const auto problem = [&count](const std::string& what) {
    if (count.first_problem.empty()) count.first_problem = what;
  };
  while (count.kills < options.kills) {
    const std::string file = folder / (std::to_string(count.campaigns++) + ".db");
    State now;
    for (int lives = 0;; ++lives) {
      const bool left_alone = lives >= 20 || count.kills >= options.kills;
      const Life life = live(words_for(file, now.begun),
                             left_alone ? 0 : random.uniform(0, 0.6) * takes.count() + 1e-4);
      if (options.loses_log && life.killed) std::filesystem::remove(file + "-wal");
      now = state_of(file);
      if (!now.verifies) {
        ++count.corrupt;
        problem("does not verify: " + file);
      }
      if (static_cast<int>(now.by_point.size()) < life.told) {
        ++count.lost;
        problem(std::to_string(life.told) + " told, " + std::to_string(now.by_point.size()) +
                " there");
        if (options.loses_log) return count;
      }
      if (life.exit_code == 0) break;
      if (!life.killed) throw std::runtime_error("exit " + std::to_string(life.exit_code));
      ++count.kills;
      count.with_points += life.told > 0 ? 1 : 0;
    }
    for (const auto& [seq, readings] : now.by_point) {
      count.repeated += readings.size() == 1 ? 0 : 1;
      count.different += same_bits(readings.front(), expected.by_point.at(seq).front()) ? 0 : 1;
    }
    if (now.by_point.size() != static_cast<std::size_t>(kPoints)) problem("a point is missing");
    for (const char* suffix : {"", "-wal", "-shm"}) {
      std::error_code ignored;
      std::filesystem::remove(file + suffix, ignored);
    }
  }
  return count;
}

KillCount sweep_socket_kills(const std::filesystem::path& folder, int points, int kills,
                             std::uint64_t seed) {
  const Plan plan = soak_plan(points);
  tests::SocketCampaign over(plan, steady());
  const std::string file = folder / "sockets.db";
  const std::vector<std::string> run = {
      "session",
      "run",
      "c",
      "--db",
      file,
      "--session",
      "s",
      "--plan",
      over.folder.write("plan.json", plan_json(plan).dump()).string(),
      "--plan-check",
      over.request.plan_check,
      "--stage",
      over.request.stage,
      "--tracker",
      over.request.tracker};
  const std::vector<std::string> resume = {"session", "resume",    "c", "--db",
                                           file,      "--session", "s"};
  const double longest_s = 0.3 + points / 500.0;  // the set-up, and a share of the points
  Random random(seed);
  KillCount count{.campaigns = 1};
  const auto problem = [&count](const std::string& what) {
    if (count.first_problem.empty()) count.first_problem = what;
  };
  State now;
  for (;;) {
    const double patience_s = count.kills < kills ? random.uniform(0.05, longest_s) : 0;
    const Life life = live(now.begun ? resume : run, patience_s, points);
    now = state_of(file, "s");
    if (!now.verifies) {
      ++count.corrupt;
      problem("does not verify");
    }
    if (static_cast<int>(now.by_point.size()) < life.told) {
      ++count.lost;
      problem(std::to_string(life.told) + " told, " + std::to_string(now.by_point.size()) +
              " there");
    }
    if (life.exit_code == 0) break;
    if (!life.killed) {
      problem("exit " + std::to_string(life.exit_code) + ": " + life.last_words);
      ++count.corrupt;
      break;
    }
    ++count.kills;
    count.with_points += life.told > 0 ? 1 : 0;
  }
  const auto& robot = over.lab.robot.robot();
  for (const auto& [seq, readings] : now.by_point) {
    count.repeated += readings.size() == 1 ? 0 : 1;
    const Reading& reading = readings.front();
    const MachinePose truly = robot.seen_pose({.cmd_mm = reading.conditions.cmd_mm,
                                               .from_mm = reading.conditions.from_mm,
                                               .epoch = 1,
                                               .time_s = 0,
                                               .temp_degc = {}});
    const Eigen::Vector3d off = reading.measured->vector() - truly.pose.vector();
    if (off.head<2>().norm() < tests::kSeenMm && std::abs(off[2]) < tests::kSeenRad) continue;
    ++count.different;
    problem("point " + std::to_string(seq) + ": " + std::to_string(off.head<2>().norm()) +
            " mm from where the platform was");
  }
  count.points = static_cast<int>(now.by_point.size());
  if (count.points != points) problem("a point is missing");
  return count;
}

}  // namespace trammel::test
