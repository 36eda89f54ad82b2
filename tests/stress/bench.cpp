#include "tests/stress/bench.hpp"

#include <signal.h>
#include <sqlite3.h>
#include <sys/stat.h>
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
#include "tests/stress/disk.hpp"
#include "tests/stress/recorder.hpp"

namespace trammel::test {

namespace {

using session::Outcome;
using tests::Alter;
using tests::SlowCampaign;
using tests::SocketCampaign;
using tests::SocketOptions;

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

/// What the campaign holds that is not what was done.
void judge(BenchRow& row, SocketCampaign& campaign, bool whole, const Outcome& outcome) {
  const auto problems = campaign.problems(whole);
  const auto lost = static_cast<int>(std::ranges::count_if(
      problems, [](const std::string& problem) { return problem.ends_with(tests::kLost); }));
  row.lost = row.lost.value_or(0) + lost;
  row.falsehoods = row.falsehoods.value_or(0) + static_cast<int>(problems.size()) - lost;
  if (!problems.empty()) note_problem(row, problems.front() + "; " + outcome.detail);
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

enum class Ends : unsigned char { unfinished, done, either };

struct Falsehood {
  const char* name;
  void (*tell)(SocketCampaign& campaign, int n, Random& random);
  Ends ends = Ends::unfinished;
};

constexpr std::array kNoNumbers = {"1e308", "-1e308", "nan", "-", "", "0x10", "1,2", "1e9"};

// From the n-th pose on.
constexpr std::array<Falsehood, 21> kFalsehoods = {{
    {"answers of another point",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::renaming());
     }},
    {"one nest's answers under the name of another",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::renaming('3', '1'));
     }},
    {"one nest's answers for another, under its right name",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::one_nest_twice());
     }},
    {"answers of the pose before",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::lagging());
     }},
    {"answers of two poses before",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::lagging(2));
     }},
    {"answers of three poses before",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::lagging(3));
     }},
    {"answers of the line before",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::one_line_behind());
     }},
    {"numbers of the tracker that are none",
     [](SocketCampaign& c, int n, Random& random) {
       c.lab.to_tracker.alter =
           tests::from_pose(n, tests::saying(kNoNumbers[random.below(kNoNumbers.size())]));
     }},
    {"numbers of the stage that are none",
     [](SocketCampaign& c, int n, Random& random) {
       c.lab.to_stage.alter_asked = [n, &c, what = kNoNumbers[random.below(kNoNumbers.size())]](
                                        std::string_view asked, std::string& answer) {
         if (!asked.starts_with("TPA") || c.lab.log.count("!MEAS") < 3 * n) return;
         answer = fmt::format(" {}{}", what, answer.substr(answer.find('\r')));
       };
     }},
    {"the same answers of the pose before, but for the last digit",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::lagging_unlike());
     }},
    {"frozen answers",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::frozen());
     }},
    {"one nest's answers frozen",
     [](SocketCampaign& c, int n, Random& random) {
       const std::string nest = "P" + std::to_string(1 + random.below(3));
       c.lab.to_tracker.alter = tests::from_pose(n, tests::only(nest, tests::frozen()));
     }},
    {"answers of 1999",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::dated("11/27/1999"));
     }},
    {"answers of no day",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::dated("99/99/0000"));
     }},
    {"answers of 2099 from an instrument whose clock is its own",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::dated("11/27/2099"));
     },
     Ends::done},
    {"an answer that comes twice",
     [](SocketCampaign& c, int n, Random& random) {
       c.lab.to_tracker.alter = doubled("P" + std::to_string(1 + random.below(3)), n);
     },
     Ends::done},
    {"a tracker knocked by 2 to 5 mm",
     [](SocketCampaign& c, int n, Random& random) {
       c.lab.to_tracker.alter = tests::knocked(n, random.uniform(2, 5));
     }},
    {"a tracker that creeps by 0.1 to 1 mm with each pose",
     [](SocketCampaign& c, int n, Random& random) {
       c.lab.to_tracker.alter = tests::creeping(n, random.uniform(0.1, 1));
     }},
    {"one answer in four of the pose before, but for the last digit",
     [](SocketCampaign& c, int n, Random& random) {
       c.lab.to_tracker.alter = tests::from_pose(
           n, tests::sometimes(Random(random.below(1'000'000)), 4, tests::lagging_unlike()));
     },
     Ends::either},
    {"answers in inches",
     [](SocketCampaign& c, int n, Random&) {
       c.lab.to_tracker.alter = tests::from_pose(n, tests::scaled(1 / 25.4));
     }},
    {"an encoder off by a turn of the screw",
     [](SocketCampaign& c, int n, Random&) { misread(c, n); }},
}};

BenchRow lied_to(const Falsehood& lie, int runs, Random& random) {
  BenchRow row{.figure = fmt::format("bench: {}", lie.name),
               .demand = lie.ends == Ends::unfinished ? "not done, and no false reading left valid"
                                                      : "each point stored once and as it was"};
  for (; row.runs < runs; ++row.runs) {
    SocketCampaign campaign(bench_plan());
    campaign.request.policy.patience_s = 30;
    lie.tell(campaign, 2 + static_cast<int>(random.below(kBenchPoints - 2)), random);
    const Outcome outcome = campaign.run();
    const bool done = outcome.state == session::State::done;
    row.done += done ? 1 : 0;
    row.readings += outcome.n_stored;
    judge(row, campaign, done, outcome);
    if (lie.ends != Ends::either && done != (lie.ends == Ends::done))
      note_problem(row, fmt::format("done: {}; {}", done, outcome.detail));
  }
  return row;
}

/// What a campaign believes that lacks what it should look with.
struct Belief {
  const char* name;
  std::size_t points;
  void (*blind)(SocketOptions& options);
  void (*tell)(SocketCampaign& campaign);
};

constexpr std::size_t kUnscreened = 4;  // points: the screen looks at six

/// Nothing looks at place, values or time: a pose before, of now and by another digit.
void tell_the_pose_before(SocketCampaign& campaign) {
  campaign.request.policy.gate_mm = 1e3;
  campaign.lab.to_tracker.alter = [lag = tests::lagging(), n = 0](std::string& answer) mutable {
    lag(answer);
    tests::shift(answer, 1e-6 * ++n);
    answer = std::regex_replace(answer, std::regex("\\d\\d/\\d\\d/\\d{4} \\d\\d:\\d\\d:\\d\\d"),
                                "01/05/2026 08:00:00");
  };
}

constexpr std::array<Belief, 4> kBeliefs = {{
    {"without gates, answers of the pose before", kUnscreened, [](SocketOptions&) {},
     &tell_the_pose_before},
    {"any triangle and no gates, answers of another point under the right name", kUnscreened,
     [](SocketOptions& options) { options.blind = true; },
     [](SocketCampaign& campaign) {
       campaign.request.policy.gate_mm = 1e3;
       campaign.request.policy.gate_deg = 180;
       campaign.lab.to_tracker.alter = tests::turned();
     }},
    {"few points and no base nests, a tracker knocked by 2 mm", 3,
     [](SocketOptions& options) { options.base_nests = false; },
     [](SocketCampaign& campaign) { campaign.lab.to_tracker.alter = tests::knocked(2, 2); }},
    {"a following error of 20 mm allowed, an encoder off by a turn of the screw", kBenchPoints,
     [](SocketOptions& options) { options.following_mm = 20; },
     [](SocketCampaign& campaign) { misread(campaign, 2); }},
}};

BenchRow believing(const Belief& belief, int runs) {
  BenchRow row{.figure = fmt::format("control: {}", belief.name),
               .demand = "must store a false reading",
               .control = true};
  Plan plan = bench_plan();
  plan.points.resize(belief.points);
  SocketOptions options;
  belief.blind(options);
  for (; row.runs < runs; ++row.runs) {
    SocketCampaign campaign(plan, options);
    belief.tell(campaign);
    const Outcome outcome = campaign.run();
    row.readings += outcome.n_stored;
    row.done += outcome.state == session::State::done ? 1 : 0;
    judge(row, campaign, false, outcome);
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
  std::atomic<bool> SlowCampaign::*stalls = nullptr;  // from then on
  bool gropes = false;                                // the reflector is lost at that time
};

constexpr std::array<Moment, 9> kMoments = {{
    {"homing", 40, "BGABC", 1, 1},
    {"homing, the stage's link stalls", 40, "BGABC", 1, 1, &SlowCampaign::stage_stalls},
    {"moving", 0, "BGABC", 2, 1},
    {"moving, the stage's link stalls", 0, "BGABC", 2, 0.5, &SlowCampaign::stage_stalls},
    {"moving, the tracker's link stalls", 0, "BGABC", 2, 0.5, &SlowCampaign::stalls},
    {"measuring", 0, "!MEAS", 5, 0.1},
    {"measuring, the tracker's link stalls", 0, "!MEAS", 5, 0.5, &SlowCampaign::stalls},
    {"looking at base nests", 0, "!MEAS", 1, 0.02},
    {"waiting for the reflector", 0, "!MEAS", 5, 0.5, nullptr, true},
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
  if (moment.stalls != nullptr) slow.*moment.stalls = true;
  lost = moment.gropes;
  session::really_sleep(late_s);
  const auto wish = SlowCampaign::Clock::now();
  slow.signals = signals;
  Stopped stopped;
  stopped.rest_s = slow.rest_after_s(wish);
  if (moment.stalls != nullptr) slow.*moment.stalls = false;
  stopped.outcome = outcome.get();
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
    note_problem(row, fmt::format("command after {:.3f} s, rest after {:.3f} s; {}",
                                  stopped.command_s, stopped.rest_s, stopped.outcome.detail));
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

struct Second {
  const char* name;
  bool link;     // to the database of the first, else another one
  bool control;  // on a controller of its own
};
constexpr std::array<Second, 3> kSeconds = {{
    {"a second database on the controller of a session", false, false},
    {"a second session by a link to the database", true, false},
    {"a second database on a controller of its own", false, true},
}};

BenchRow second_runner(const Second& second, int runs) {
  BenchRow row{.figure = fmt::format("{}: {}", second.control ? "control" : "bench", second.name),
               .demand = second.control ? "must run" : "refused, and not a word to the controller",
               .control = second.control};
  for (; row.runs < runs; ++row.runs) {
    SocketCampaign campaign(bench_plan()), elsewhere(bench_plan());
    const auto file = campaign.folder.path() / "second.db";
    if (second.link) std::filesystem::create_symlink(campaign.db.file(), file);
    store::Connection other = store::open(file, store::Access::create);
    session::Request request = second.control ? elsewhere.request : campaign.request;
    request.session = "second";
    campaign.begun = [&](int seq) {
      if (seq != 2) return;
      const auto before = campaign.lab.log.size();
      try {
        static_cast<void>(session::run(other, request, {}));
        note_problem(row, "both are driven");
      } catch (const Error&) {
        if (campaign.lab.log.size() != before) note_problem(row, "it was spoken to");
      }
    };
    const Outcome outcome = campaign.run();
    row.done += outcome.state == session::State::done ? 1 : 0;
    row.readings += outcome.n_stored;
    if (outcome.state != session::State::done && !second.control) note_problem(row, outcome.detail);
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
  bool loses;                      // from under a recorder that looks at no answer
  bool fills = false;              // the disk takes nothing more
};

constexpr std::array<Meddling, 10> kMeddlings = {{
    {"removed", [](const Path& db) { std::filesystem::remove(db); }, true},
    {"removed with its log", &remove_all_of, true},
    {"moved", [](const Path& db) { std::filesystem::rename(db, db.string() + ".moved"); }, true},
    {"replaced by a folder",
     [](const Path& db) {
       std::filesystem::remove(db);
       std::filesystem::create_directory(db);
     },
     false},
    {"replaced by a pipe",
     [](const Path& db) {
       std::filesystem::remove(db);
       ::mkfifo(db.c_str(), 0600);
     },
     false},
    {"replaced by a second name of another laboratory's",
     [](const Path& db) {
       std::filesystem::remove(db);
       std::filesystem::create_hard_link(db.parent_path() / "old.db", db);
     },
     false},
    {"replaced by another laboratory's",
     [](const Path& db) {
       copy_over(db.parent_path() / "old.db", db.string() + ".new");
       std::filesystem::rename(db.string() + ".new", db);
     },
     false},  // the log is left, and SQLite reads it with the other file
    {"restored over, under its name and number",
     [](const Path& db) { copy_over(db.parent_path() / "old.db", db); }, false},
    {"without its log", [](const Path& db) { std::filesystem::remove(db.string() + "-wal"); },
     false},
    {"on a disk that is full", [](const Path&) {}, true, true},
}};

BenchRow meddled(const Meddling& meddling, const Recorder& recorder, bool control, int runs,
                 Random& random) {
  constexpr int kMeddledPoints = 12;
  BenchRow row{
      .figure = fmt::format("{}: the database is {} in the middle of a session",
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
    bool meddled = false;
    Recording recording;
    {
      const WatchedDisk disk([&](const DiskOperation& operation) {
        const bool full = meddled && meddling.fills;
        return full && operation.kind == DiskOperation::Kind::write ? SQLITE_FULL : SQLITE_OK;
      });
      recording = recorder.record(db, kMeddledPoints, [&](int acknowledged) {
        if (acknowledged < at || std::exchange(meddled, true)) return;
        meddling.meddle(db);
      });
    }
    row.readings += recording.acknowledged;
    row.done += recording.reported ? 0 : 1;
    const Found found = recorder.look(db);
    const bool whole = found.verifies && found.n_points >= recording.acknowledged;
    row.lost = row.lost.value_or(0);
    if (!recording.reported && !whole) {
      *row.lost += recording.acknowledged - found.n_points;
      note_problem(row, fmt::format("{} acknowledged, {} there, and nothing was reported",
                                    recording.acknowledged, found.n_points));
    }
    if (recording.reported && recording.code != ExitCode::storage) {
      note_problem(row, "another exit code: " + recording.error);
    }
  }
  return row;
}

}  // namespace

int kinds_of_lies() { return static_cast<int>(kFalsehoods.size()); }

std::vector<BenchRow> lying_bench(int runs, std::uint64_t seed) {
  Random random(seed);
  std::vector<BenchRow> rows;
  for (const Falsehood& lie : kFalsehoods) rows.push_back(lied_to(lie, runs, random));
  for (const Belief& belief : kBeliefs) rows.push_back(believing(belief, std::min(runs, 3)));
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
  std::vector<BenchRow> rows = {
      signalled(SIGHUP, 0, false, runs), signalled(SIGTERM, 0, false, runs),
      signalled(SIGKILL, kWatchS, false, runs), signalled(SIGKILL, 0, true, 1)};
  for (const Second& second : kSeconds) {
    rows.push_back(second_runner(second, second.control ? 1 : runs));
  }
  return rows;
}

std::vector<BenchRow> file_bench(int runs, std::uint64_t seed) {
  Random random(seed);
  std::vector<BenchRow> rows;
  for (const Meddling& meddling : kMeddlings) {
    rows.push_back(meddled(meddling, real_recorder(), false, runs, random));
    if (meddling.loses) rows.push_back(meddled(meddling, careless_recorder(), true, 1, random));
  }
  return rows;
}

}  // namespace trammel::test
