#include "tests/stress/bench.hpp"

#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <future>
#include <utility>

#include "app/session/hands.hpp"
#include "core/statistics/random.hpp"
#include "tests/app/session/proxies.hpp"
#include "tests/app/session/slow_campaign.hpp"
#include "tests/stress/recorder.hpp"

namespace trammel::test {

namespace {

using session::Outcome;
using tests::Alter;
using tests::SlowCampaign;
using tests::SocketCampaign;

constexpr std::size_t kBenchPoints = 8;

Plan bench_plan() {
  Plan plan = tests::small_plan();
  plan.points.resize(kBenchPoints);
  return plan;
}

void note_problem(BenchRow& row, const std::string& what) {
  ++row.wrong;
  if (row.first_problem.empty()) row.first_problem = what;
}

// ---- answers that lie ----

/// The n-th answer for one point, twice.
Alter doubled(std::string point, int n) {
  return [point = std::move(point), n, seen = 0](std::string& answer) mutable {
    if (tests::point_of(answer) == point && ++seen == n) answer += answer;
  };
}

/// A rail's encoder is off by a turn of its screw from the n-th measurement on.
void misread(SocketCampaign& campaign, int n) {
  constexpr long kTurn = 8192;
  campaign.lab.to_stage.alter_asked = [n, &campaign](std::string_view asked, std::string& answer) {
    if (!asked.starts_with("TPA") || campaign.lab.log.count("!MEAS") < 3 * n) return;
    answer = fmt::format(" {}{}", std::stol(answer) + kTurn, answer.substr(answer.find('\r')));
  };
}

struct Falsehood {
  const char* name;
  void (*tell)(SocketCampaign& campaign, int n, Random& random);
  bool ends_well = false;  // the campaign comes to its end
};

// From the n-th pose on.
constexpr std::array<Falsehood, 9> kFalsehoods = {{
    {"answers of another point",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::renaming());
     }},
    {"answers of the pose before",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::lagging());
     }},
    {"the same, but for the last digit",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::lagging_unlike());
     }},
    {"frozen answers",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::frozen());
     }},
    {"answers of 1999",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::dated("11/27/1999"));
     }},
    {"answers of no day",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::dated("99/99/0000"));
     }},
    {"an answer that comes twice",
     [](SocketCampaign& c, int n, Random& random) {
       c.lab.to_tracker.alter = doubled("P" + std::to_string(1 + random.below(3)), n);
     },
     true},
    {"a tracker knocked by 2 to 5 mm",
     [](SocketCampaign& c, int n, Random& random) {
       c.lab.to_tracker.alter = tests::knocked(n, random.uniform(2, 5));
     }},
    {"an encoder off by a turn of the screw",
     [](SocketCampaign& c, int n, Random&) { misread(c, n); }},
}};

BenchRow lied_to(const Falsehood& lie, int runs, Random& random) {
  BenchRow row{.figure = fmt::format("bench: {}", lie.name),
               .demand = lie.ends_well ? "each point stored once and as it was"
                                       : "0 false readings in a session that is done"};
  for (; row.runs < runs; ++row.runs) {
    SocketCampaign campaign(bench_plan());
    campaign.request.policy.patience_s = 30;
    lie.tell(campaign, 2 + static_cast<int>(random.below(kBenchPoints - 2)), random);
    const Outcome outcome = campaign.run();
    const bool done = outcome.state == session::State::done;
    row.done += done ? 1 : 0;
    row.readings += outcome.n_stored;
    const auto problems = campaign.problems(done);
    // What a knock has left before it was noticed is said, and the session is not done.
    const bool said = !done && outcome.detail.find("moved") != std::string::npos;
    if (!problems.empty() && !said) note_problem(row, problems.front());
    if (done != lie.ends_well) note_problem(row, fmt::format("done: {}; {}", done, outcome.detail));
  }
  return row;
}

/// Nothing looks at time, values or place: a pose before, of now and by another digit, is stored.
BenchRow believing(int runs) {
  BenchRow row{.figure = "control: without gates, answers of the pose before",
               .demand = "must store a false reading",
               .control = true};
  for (; row.runs < runs; ++row.runs) {
    SocketCampaign campaign(bench_plan());
    campaign.request.policy.gate_mm = 1e3;
    campaign.lab.to_tracker.alter = [lag = tests::lagging(), n = 0](std::string& answer) mutable {
      lag(answer);
      tests::shift(answer, 1e-6 * ++n);
      answer = std::regex_replace(answer, std::regex("\\d\\d/\\d\\d/\\d{4} \\d\\d:\\d\\d:\\d\\d"),
                                  "01/05/2026 08:00:00");
    };
    row.readings += campaign.run().n_stored;
    if (const auto problems = campaign.problems(false); !problems.empty()) {
      note_problem(row, problems.front());
    }
  }
  return row;
}

// ---- wishes to stop ----

struct Moment {
  const char* name;
  double start_mm;   // of the rails, from their switches
  const char* line;  // that has come so often when the wish comes, up to `late_s` later
  int times;
  double late_s;
  bool stalls = false;  // the tracker's link, from then on
  bool gropes = false;  // the reflector is lost at that time
};

constexpr std::array<Moment, 7> kMoments = {{
    {"homing", 40, "BGABC", 1, 1},
    {"moving", 0, "BGABC", 2, 1},
    {"moving, the tracker's link stalls", 0, "BGABC", 2, 0.5, true},
    {"measuring", 0, "!MEAS", 5, 0.1},
    {"measuring, the tracker's link stalls", 0, "!MEAS", 5, 0.5, true},
    {"looking at base nests", 0, "!MEAS", 1, 0.02},
    {"waiting for the reflector", 0, "!MEAS", 5, 0.5, false, true},
}};

struct Stopped {
  double command_s = 0, rest_s = 0;
  Outcome outcome;
};

Stopped stopped_at(const Moment& moment, double late_s, int signals) {
  std::atomic<bool> lost = false;
  SlowCampaign slow(moment.start_mm);
  slow.around.sleep = [](double s) { session::really_sleep(s); };
  slow.lab.to_tracker.alter_asked = [&lost](std::string_view asked, std::string& answer) {
    if (lost && asked.starts_with("?STAT")) answer = "ERR-338 no target is locked\r\n";
  };
  auto outcome = std::async(std::launch::async, [&slow] { return slow.run(); });
  slow.await(moment.line, moment.times);
  slow.stalls = moment.stalls;
  lost = moment.gropes;
  session::really_sleep(late_s);
  const auto wish = SlowCampaign::Clock::now();
  slow.signals = signals;
  Stopped stopped;
  stopped.rest_s = slow.rest_after_s(wish);
  stopped.outcome = outcome.get();
  slow.stalls = false;
  stopped.command_s = slow.stop_after_s(wish);
  return stopped;
}

BenchRow asked_to_stop(const Moment& moment, int runs, Random& random) {
  constexpr double kRestS = session::kStopDelayS + 0.2 + 0.1;  // 20 mm/s at 100 mm/s^2; this look
  BenchRow row{.figure = fmt::format("bench: stop now while {}", moment.name),
               .demand = "the stop command within 0.3 s, rest v / a later"};
  for (; row.runs < runs; ++row.runs) {
    const Stopped stopped = stopped_at(moment, random.uniform(0, moment.late_s), 2);
    row.worst_s = std::max(row.worst_s, stopped.command_s);
    row.done += stopped.outcome.state == session::State::done ? 1 : 0;
    row.readings += stopped.outcome.n_stored;
    if (stopped.command_s <= session::kStopDelayS && stopped.rest_s <= kRestS) continue;
    note_problem(row, fmt::format("command after {:.3f} s, rest after {:.3f} s", stopped.command_s,
                                  stopped.rest_s));
  }
  return row;
}

// ---- signals to the real program ----

constexpr double kWatchS = 0.5;

BenchRow signalled(int signal, double watch_s, bool control, int runs) {
  BenchRow row{.figure = fmt::format("{}: {} to the program while its rails home{}",
                                     control ? "control" : "bench", ::sigabbrev_np(signal),
                                     watch_s > 0 ? ", the controller watches it" : ""),
               .demand = control ? "the rails must go on"
                                 : fmt::format("at rest v / a after {} s",
                                               watch_s > 0 ? watch_s : session::kStopDelayS),
               .control = control};
  // v / a of homing, 5 mm/s at 100 mm/s^2, and a look.
  const double patience_s = std::max(watch_s, session::kStopDelayS) + 0.05 + 0.1;
  for (; row.runs < runs; ++row.runs) {
    SlowCampaign slow(60, watch_s);
    const pid_t child = slow.program_homes();
    ::kill(child, signal);
    session::really_sleep(patience_s);
    const bool moves = slow.lab.robot.standing().moving;
    if (moves) note_problem(row, "they move");
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
  return row;
}

BenchRow two_on_one(int runs) {
  BenchRow row{.figure = "bench: a second database on the controller of a session",
               .demand = "refused, and not a word to the controller"};
  for (; row.runs < runs; ++row.runs) {
    SocketCampaign campaign(bench_plan());
    store::Connection other =
        store::open(campaign.folder.path() / "other.db", store::Access::create);
    campaign.begun = [&](int seq) {
      if (seq != 2) return;
      const auto before = campaign.lab.log.size();
      try {
        static_cast<void>(session::run(other, campaign.request, {}));
        note_problem(row, "both drive it");
      } catch (const Error&) {
        if (campaign.lab.log.size() != before) note_problem(row, "it was spoken to");
      }
    };
    const Outcome outcome = campaign.run();
    row.done += outcome.state == session::State::done ? 1 : 0;
    row.readings += outcome.n_stored;
    if (outcome.state != session::State::done) note_problem(row, outcome.detail);
  }
  return row;
}

// ---- files ----

using Path = std::filesystem::path;

void remove_all_of(const Path& db) {
  for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(db.string() + suffix);
}

void copy_over(const Path& from, const Path& to) {
  std::filesystem::copy_file(from, to, std::filesystem::copy_options::overwrite_existing);
}

struct Meddling {
  const char* name;
  void (*meddle)(const Path& db);  // beside it lies old.db, of another laboratory
};

constexpr std::array<Meddling, 5> kMeddlings = {{
    {"removed", [](const Path& db) { std::filesystem::remove(db); }},
    {"removed with its log", &remove_all_of},
    {"moved", [](const Path& db) { std::filesystem::rename(db, db.string() + ".moved"); }},
    {"replaced by another laboratory's",
     [](const Path& db) {
       copy_over(db.parent_path() / "old.db", db.string() + ".new");
       std::filesystem::rename(db.string() + ".new", db);
     }},
    {"its log removed", [](const Path& db) { std::filesystem::remove(db.string() + "-wal"); }},
}};

BenchRow meddled(const Meddling& meddling, const Recorder& recorder, bool control, int runs,
                 Random& random) {
  constexpr int kMeddledPoints = 12;
  BenchRow row{
      .figure = fmt::format("{}: the database is {} under a session",
                            control ? "control: a recorder that looks at no answer" : "bench",
                            meddling.name),
      .demand = control ? "must lose, and not report"
                        : "reported with 8, or all acknowledged readings are there by name",
      .control = control};
  for (; row.runs < runs; ++row.runs) {
    const tests::TemporaryFolder folder;
    static_cast<void>(record(folder.path() / "old.db", 2));
    const Path db = folder.path() / "lab.db";
    const int at = 1 + static_cast<int>(random.below(kMeddledPoints - 1));
    bool meddles = true;
    const Recording recording = recorder.record(db, kMeddledPoints, [&](int told) {
      if (!std::exchange(meddles, meddles && told < at)) return;
      if (told >= at) meddling.meddle(db);
    });
    row.readings += recording.acknowledged;
    row.done += recording.reported ? 0 : 1;
    const Found found = recorder.look(db);
    if (!recording.reported && found.n_points < recording.acknowledged) {
      note_problem(row, fmt::format("{} acknowledged, {} there, and nothing was said",
                                    recording.acknowledged, found.n_points));
    }
    if (recording.reported && recording.code != ExitCode::storage) {
      note_problem(row, "another exit code: " + recording.error);
    }
  }
  return row;
}

}  // namespace

std::vector<BenchRow> lying_bench(int runs, std::uint64_t seed) {
  Random random(seed);
  std::vector<BenchRow> rows;
  for (const Falsehood& lie : kFalsehoods) rows.push_back(lied_to(lie, runs, random));
  rows.push_back(believing(std::min(runs, 3)));
  return rows;
}

std::vector<BenchRow> stop_bench(int runs, std::uint64_t seed) {
  Random random(seed);
  std::vector<BenchRow> rows;
  for (const Moment& moment : kMoments) rows.push_back(asked_to_stop(moment, runs, random));
  BenchRow control{.figure = "control: asked to finish the point while homing",
                   .demand = "must go on beyond 0.3 s",
                   .runs = 1,
                   .control = true};
  control.worst_s = stopped_at(kMoments[0], 0.1, 1).command_s;
  if (control.worst_s > session::kStopDelayS) ++control.wrong;
  rows.push_back(control);
  return rows;
}

std::vector<BenchRow> signal_bench(int runs) {
  return {signalled(SIGHUP, 0, false, runs), signalled(SIGTERM, 0, false, runs),
          signalled(SIGKILL, kWatchS, false, runs), signalled(SIGKILL, 0, true, 1),
          two_on_one(runs)};
}

std::vector<BenchRow> file_bench(int runs, std::uint64_t seed) {
  Random random(seed);
  std::vector<BenchRow> rows;
  for (const Meddling& meddling : kMeddlings) {
    rows.push_back(meddled(meddling, real_recorder(), false, runs, random));
  }
  rows.push_back(meddled(kMeddlings[1], careless_recorder(), true, 3, random));
  return rows;
}

}  // namespace trammel::test
