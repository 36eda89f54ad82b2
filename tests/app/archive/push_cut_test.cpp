// A push that is cut anywhere leaves all of a campaign or nothing, and goes on when it is run
// again.

#include <chrono>
#include <set>
#include <thread>

#include "app/archive/pull.hpp"
#include "store/open.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/relay.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using store::Access;
using store::Connection;
using tests::Cut;
using tests::kStationA;
using tests::push_all;

namespace {

using What = Cut::What;

/// A station whose campaigns are pushed through a relay, one after the other.
class Cuts {
 public:
  explicit Cuts(tests::Postgres& server)
      : server_(server), archive_(server.new_archive()), file_(folder_.file("lab.db")) {
    Connection db = store::open(file_, Access::create);
  }

  [[nodiscard]] std::string direct() const { return server_.uri(archive_, "robot_a"); }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] std::filesystem::path beside(const char* name) const { return folder_.file(name); }

  struct Outcome {
    bool acknowledged = false;
    bool has_cut = false;
    long messages = 0, bytes = 0;
  };
  /// Adds a campaign and pushes it with this cut.
  Outcome push(Cut cut) {
    {
      Connection db = store::open(file_, Access::write);
      tests::add_full_campaign(db, "campaign " + std::to_string(++n_));
    }
    tests::Relay relay(server_.socket_folder(), server_.port(), cut);
    Outcome outcome;
    try {
      push_all(relay.uri(archive_, "robot_a"), file_, kStationA);
      outcome.acknowledged = true;
    } catch (const Error&) {
    }
    const bool asked = cut.what != What::never || cut.lie_of_commit;
    for (int k = 0; asked && !relay.has_cut() && k < 100; ++k) {  // the last message, as it goes
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    outcome.has_cut = relay.has_cut();
    outcome.messages = relay.messages();
    outcome.bytes = relay.bytes();
    return outcome;
  }

  /// Of the last campaign: "all", "nothing", or what there is of it.
  [[nodiscard]] std::string archived() const {
    Connection db = store::open_as_it_is(file_);
    const archive::CampaignName last = archive::campaigns_of(db).back();
    const archive::Head local = archive::local_head(db, last);
    const std::string of = " WHERE campaign = '" + last.uuid + "'";
    const std::string there =
        tests::asked(direct(), "SELECT (SELECT count(*) FROM trammel.reading" + of +
                                   ") || ' ' || (SELECT count(*) FROM trammel.archive_row" + of +
                                   ") || ' ' || coalesce((SELECT encode(head, 'hex') FROM "
                                   "trammel.campaign_head" +
                                   of + "), 'none')");
    const std::string all =
        std::to_string(local.n_readings) + " " + std::to_string(local.n_rows) + " " + local.head;
    return there == all ? "all" : there == "0 0 none" ? "nothing" : there;
  }

  void resume_and_check() {
    push_all(direct(), file_, kStationA);
    CHECK(archived() == "all");
  }

 private:
  tests::Postgres& server_;
  std::string archive_;
  test::TempFolder folder_;
  std::filesystem::path file_;
  int n_ = 0;
};

}  // namespace

TEST_CASE("a push that is cut at any message leaves all or nothing, and resumes", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  Cuts cuts(*server);
  const Cuts::Outcome whole = cuts.push({});
  REQUIRE(whole.acknowledged);
  REQUIRE(cuts.archived() == "all");
  int n_nothing = 0;
  for (long after = 1; after < whole.messages; ++after) {
    CAPTURE(after);
    const Cuts::Outcome cut = cuts.push({What::client_messages, after});
    CHECK(cut.has_cut);
    const std::string archived = cuts.archived();
    CHECK((archived == "all" || archived == "nothing"));
    CHECK((!cut.acknowledged || archived == "all"));
    n_nothing += archived == "nothing";
    cuts.resume_and_check();
  }
  CHECK(n_nothing > 8);  // BEGIN, the head, COPY's parts, the look at the new head
  // Nothing lost, doubled or altered.
  CHECK(tests::asked(cuts.direct(), "SELECT count(*) FROM trammel.findings()") == "0");
  archive::Link link({.uri = cuts.direct(), .who = "tests"});
  static_cast<void>(archive::pull(link, {.station = kStationA}, cuts.beside("again.db")));
  CHECK(tests::content(cuts.beside("again.db")) == tests::content(cuts.file()));
}

TEST_CASE("a push that is cut within a message, or while the server answers, resumes",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  Cuts cuts(*server);
  const Cuts::Outcome whole = cuts.push({});
  REQUIRE(whole.acknowledged);
  std::set<std::string> seen;
  for (int part = 1; part <= 12; ++part) {
    for (const What what : {What::client_bytes, What::server_bytes}) {
      // The server's answers of a push of one campaign are some 3000 bytes.
      const long all = what == What::client_bytes ? whole.bytes : 3000;
      CAPTURE(part, static_cast<int>(what));
      const Cuts::Outcome cut = cuts.push({what, all * part / 13});
      const std::string archived = cuts.archived();
      CHECK((archived == "all" || archived == "nothing"));
      CHECK((!cut.acknowledged || archived == "all"));
      seen.insert(archived);
      cuts.resume_and_check();
    }
  }
  CHECK(seen.contains("nothing"));
  CHECK(tests::asked(cuts.direct(), "SELECT count(*) FROM trammel.findings()") == "0");
}

// The control: what is acknowledged before it is committed is lost, and these tests see it.
TEST_CASE("a push that is acknowledged before the commit is found to be lost", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  Cuts cuts(*server);
  const Cuts::Outcome lied = cuts.push({.lie_of_commit = true});
  CHECK(lied.has_cut);
  CHECK(lied.acknowledged);
  CHECK(cuts.archived() == "nothing");
  cuts.resume_and_check();  // and the file, which keeps no list of what was pushed, sends it again
}

TEST_CASE("a killed client leaves all or nothing of each campaign, and resumes", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string uri = server->uri(server->new_archive(), "robot_a");
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    Connection db = store::open(file, Access::create);
    for (int n = 0; n < 12; ++n) tests::add_full_campaign(db, "campaign " + std::to_string(n));
  }
  REQUIRE(tests::run_program({"archive", "init", uri, "--db", file}, folder.path()).exit_code == 0);
  bool killed = false;
  for (const int after_ms : {15, 25, 40, 60, 90}) {
    killed |=
        tests::run_program({"archive", "push", "--db", file}, folder.path(), after_ms).exit_code ==
        -1;
    CHECK(tests::asked(uri, "SELECT count(*) FROM trammel.findings()") == "0");
  }
  CHECK(killed);
  const tests::Finished done = tests::run_program({"archive", "push", "--db", file}, folder.path());
  CAPTURE(done.err);
  CHECK(done.exit_code == 0);
  CHECK(tests::run_program({"archive", "pull", "--db", file, "--out", "again.db"}, folder.path())
            .exit_code == 0);
  CHECK(tests::content(folder.file("again.db")) == tests::content(file));
}
