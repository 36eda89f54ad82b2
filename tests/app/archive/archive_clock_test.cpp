// Clocks of stations and workers that are days apart: what the archive decides, it decides by its
// own.

#include <nlohmann/json.hpp>

#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using tests::asked;

namespace {

constexpr int kAhead = 86400, kBehind = -86400;  // s

/// Runs a program whose clock is so far off, for at most `for_s`, and then kills it.
tests::Finished at_clock(int off_s, const std::vector<std::string>& words,
                         const std::filesystem::path& folder, double for_s = 60) {
  std::vector<std::string> all = {
      "timeout",
      "-s",
      "KILL",
      std::to_string(for_s),
      "env",
      "LD_PRELOAD=" + tests::build_folder() + "/tests/libother_clock.so",
      "OTHER_CLOCK_S=" + std::to_string(off_s)};
  all.insert(all.end(), words.begin(), words.end());
  return tests::run_command(all, folder);
}

/// An archive with a campaign of two stations: "ahead", whose clock is, pushed first.
struct Apart {
  explicit Apart(tests::Postgres& of) : server(of), name(of.new_archive()) {
    for (const auto& [station, off_s] :
         {std::pair("ahead", kAhead), std::pair("behind", kBehind)}) {
      run(off_s, {"campaign", "import", tests::kDriveError, "--name", station}, station);
      run(off_s, {"archive", "init", as("robot_a")}, station);
      run(off_s, {"archive", "push"}, station);
    }
    for (const char* worker : {"first", "second"})
      run(0, {"archive", "init", as("worker")}, worker);
  }
  [[nodiscard]] std::string as(const std::string& role) const { return server.uri(name, role); }
  std::string run(int off_s, std::vector<std::string> words, const std::string& database) const {
    words.insert(words.begin(), tests::build_folder() + "/trammel");
    words.insert(words.end(), {"--json", "--db", database + ".db"});
    const auto done = at_clock(off_s, words, folder.path());
    CAPTURE(words, done.err);
    REQUIRE(done.exit_code == 0);
    return done.out;
  }
  /// What a worker computes, until it is killed.
  void work(int off_s, const std::string& worker, double for_s = 3) const {
    static_cast<void>(at_clock(off_s,
                               {tests::build_folder() + "/trammel-archive", "work", "--until-empty",
                                "--db", worker + ".db"},
                               folder.path(), for_s));
  }
  tests::Postgres& server;
  std::string name;
  test::TempFolder folder;
};

}  // namespace

TEST_CASE("the newest, and what is queued, are so by the server's clock", "[archive][release]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Apart archive(*server);
  // The control: their clocks are two days apart, and so are the times that they stored themselves.
  CHECK(asked(archive.as("visitor"),
              "SELECT round(extract(epoch FROM max(created_utc::timestamptz) - "
              "min(created_utc::timestamptz)) / 86400) FROM trammel.campaign") == "2");
  CHECK(asked(archive.as("visitor"),
              "SELECT bool_and(moved_at BETWEEN now() - interval '5 min' AND now()) FROM "
              "trammel.campaign_head") == "t");
  const auto listed =
      nlohmann::json::parse(archive.run(kAhead, {"archive", "list", "--newest", "1"}, "ahead"));
  CHECK(listed["campaigns"][0]["name"] == "behind");
  archive.run(kAhead, {"archive", "rerun", "--stage", "lsq", "--newest", "1"}, "ahead");
  CHECK(asked(archive.as("visitor"),
              "SELECT string_agg(name, ' ') FROM trammel.work JOIN trammel.campaign USING "
              "(campaign)") == "behind");
}

TEST_CASE("a lease ends by the server's clock, whatever the workers' say", "[archive][release]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Apart archive(*server);
  archive.run(0, {"archive", "rerun", "--stage", "lsq", "--campaign", "behind"}, "behind");
  const auto holder = [&] {
    return asked(archive.as("visitor"), "SELECT concat(state, ' ', token) FROM trammel.work");
  };
  archive::Link owner({.uri = archive.as("owner"), .who = "tests"});
  {
    // A worker is killed over its work: what it asks for next is locked.
    const archive::Link::Transaction locked(owner);
    owner.run("LOCK TABLE trammel.result");
    archive.work(kAhead, "first");
  }
  const std::string held = holder();
  REQUIRE(held.starts_with("claimed"));
  CHECK(asked(archive.as("visitor"),
              "SELECT lease_until BETWEEN now() AND now() + interval '60 s' FROM trammel.work") ==
        "t");
  for (const int off_s : {kAhead, kBehind}) {
    archive.work(off_s, "second");
    CHECK(holder() == held);
  }
  // The control: as if it were a day later for the one who claims.
  const std::string claim =
      asked(archive.as("owner"), "SELECT pg_get_functiondef('trammel.claim'::regproc)");
  std::string a_day_later = claim;
  const std::string ended = "lease_until < now()";
  a_day_later.replace(a_day_later.find(ended), ended.size(), ended + " + interval '1 day'");
  owner.run(a_day_later);
  archive.work(kBehind, "second", 60);
  CHECK(holder().starts_with("done"));
}
