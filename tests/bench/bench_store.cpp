// The store against a bare loop over SQLite with the same settings on the same disk.

#include <sqlite3.h>

#include <algorithm>
#include <cstdio>

#include "store/campaign.hpp"
#include "store/open.hpp"
#include "store/session.hpp"
#include "tests/bench/bench.hpp"

namespace trammel::bench {

namespace {

using Path = std::filesystem::path;

constexpr int kRecorded = 1500, kImported = 50'000, kColumns = 22;

/// A table of the columns that hold numbers, one index, nothing checked.
class Bare {
 public:
  explicit Bare(const Path& file) {
    std::filesystem::remove(file);
    sqlite3_open(file.c_str(), &db_);
    run("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL");
    std::string columns, marks;
    for (int k = 0; k < kColumns; ++k) {
      columns += ", c" + std::to_string(k) + " REAL";
      marks += ", ?";
    }
    run("CREATE TABLE reading (id INTEGER PRIMARY KEY, seq INTEGER" + columns + ", UNIQUE (seq))");
    sqlite3_prepare_v2(db_, ("INSERT INTO reading VALUES (NULL, ?" + marks + ")").c_str(), -1,
                       &insert_, nullptr);
  }
  ~Bare() {
    sqlite3_finalize(insert_);
    sqlite3_close(db_);
  }
  Bare(const Bare&) = delete;
  Bare& operator=(const Bare&) = delete;

  void run(const std::string& sql) { sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr); }
  void add(int seq) {
    sqlite3_bind_int(insert_, 1, seq);
    for (int k = 0; k < kColumns; ++k) sqlite3_bind_double(insert_, k + 2, 0.1 * seq + k);
    if (sqlite3_step(insert_) != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(db_));
    sqlite3_reset(insert_);
  }

 private:
  sqlite3* db_ = nullptr;
  sqlite3_stmt* insert_ = nullptr;
};

Campaign campaign(int n) {
  Campaign c;
  c.name = "bench";
  c.machine = machine_of(paper_mechanism());
  for (int seq = 1; seq <= n; ++seq) {
    Reading r;
    r.seq = seq;
    r.target = {0.001 * seq, 1, 0};
    r.conditions = {.cmd_mm = {200 + 1e-5 * seq, 210, 220}, .from_mm = {200, 210, 220.1}};
    r.measured = Pose{0.001 * seq + 0.01, 1.1, 1e-5};
    c.readings.push_back(r);
  }
  return c;
}

struct Times {
  std::vector<double> s;
  [[nodiscard]] double total() const {
    double sum = 0;
    for (const double t : s) sum += t;
    return sum;
  }
  [[nodiscard]] double p99() {
    std::sort(s.begin(), s.end());
    return s[s.size() * 99 / 100];
  }
};

template <class Work>
void timed(Times& times, const Work& work) {
  times.s.push_back(best(1, work, clock_s));
}

}  // namespace

/// Prints: ours, bare (seconds), ours p99, bare p99. A point is two commits, the intent and the
/// reading, on both sides; the two take turns.
void record(const Path& folder) {
  std::filesystem::remove(folder / "record.db");
  store::Connection db = store::open(folder / "record.db", store::Access::create);
  const store::Id id = store::add_campaign(db, campaign(0));
  std::vector<store::Point> plan;
  for (int seq = 1; seq <= kRecorded; ++seq)
    plan.push_back({.seq = seq, .target = {0.01 * seq, 1, 0}});
  const store::Id session =
      store::create_session(db, {.campaign_id = id, .name = "s", .points = plan});
  const auto epoch = store::open_epoch(db, session, store::SetUp::fresh, "start");
  Bare bare(folder / "bare.db");
  bare.run("CREATE TABLE attempt (id INTEGER PRIMARY KEY, seq INTEGER, status TEXT)");
  const Campaign readings = campaign(kRecorded);
  Times ours, theirs;
  for (int seq = 1; seq <= kRecorded; ++seq) {
    timed(ours, [&] {
      const auto attempt = store::begin_attempt(db, session, seq, epoch.id);
      store::NewReading reading{.reading = readings.readings[static_cast<std::size_t>(seq - 1)]};
      reading.reading.seq = 0;
      store::finish_attempt(db, attempt, {reading});
    });
    timed(theirs, [&] {
      bare.run("INSERT INTO attempt (seq, status) VALUES (1, 'open')");
      bare.run("BEGIN");
      bare.add(seq);
      bare.run("UPDATE attempt SET status = 'ok' WHERE id = " + std::to_string(seq));
      bare.run("COMMIT");
    });
  }
  std::printf("%.9g %.9g %.9g %.9g\n", ours.total(), theirs.total(), ours.p99(), theirs.p99());
}

/// Prints: ours, bare (seconds, best of three).
void import_readings(const Path& folder) {
  const Campaign c = campaign(kImported);
  double ours = 1e300, theirs = 1e300;
  for (int round = 0; round < 3; ++round) {
    std::filesystem::remove(folder / "import.db");
    {
      store::Connection db = store::open(folder / "import.db", store::Access::create);
      ours = std::min(ours, best(
                                1, [&] { store::import_campaign(db, c); }, clock_s));
    }
    Bare bare(folder / "bulk.db");
    theirs = std::min(theirs, best(
                                  1,
                                  [&] {
                                    bare.run("BEGIN");
                                    for (int seq = 1; seq <= kImported; ++seq) bare.add(seq);
                                    bare.run("COMMIT");
                                  },
                                  clock_s));
  }
  std::printf("%.9g %.9g\n", ours, theirs);
}

}  // namespace trammel::bench
