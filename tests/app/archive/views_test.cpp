// The archive answers as the station's own file does.

#include <algorithm>
#include <cmath>

#include "app/files/numbers.hpp"
#include "app/job/run.hpp"
#include "app/report/accuracy.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "store/open.hpp"
#include "store/query.hpp"
#include "store/session.hpp"
#include "store/transaction.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using tests::read_text;
using tests::run_program;

namespace {

/// A view as a table of texts: what `trammel query` answers on the station's file.
struct Rows {
  std::vector<std::string> columns = {};
  std::vector<std::vector<std::string>> rows = {};
};

Rows own_rows(const std::filesystem::path& file, const std::string& view) {
  store::Connection db = store::open(file, store::Access::read_only);
  store::provide(db, report::accuracy(db));
  // Open attempts are not sent.
  const std::string sent =
      view == "v_point_status" ? " WHERE status NOT IN ('open', 'planned')" : "";
  store::Query query(db, "SELECT * FROM " + view + sent, std::chrono::seconds(10));
  Rows own{.columns = query.columns()};
  while (const auto row = query.next()) {
    auto& line = own.rows.emplace_back();
    for (const store::Cell& cell : *row) {
      const auto* text = std::get_if<std::string>(&cell);
      const auto* integer = std::get_if<std::int64_t>(&cell);
      const auto* real = std::get_if<double>(&cell);
      line.push_back(text      ? *text
                     : integer ? std::to_string(*integer)
                     : real    ? number_text(*real)
                               : "");
    }
  }
  return own;
}

std::vector<std::vector<std::string>> archived_rows(const std::string& uri, const std::string& view,
                                                    const std::vector<std::string>& columns) {
  std::string list;
  for (const std::string& column : columns) list += column + ", ";
  archive::Link link({.uri = uri, .who = "tests"});
  const std::string sent = view == "v_point_status" ? " WHERE status <> 'planned'" : "";
  std::vector<std::vector<std::string>> all;
  for (const auto& row : link.ask("SELECT " + list + "station FROM trammel." + view + sent)) {
    CHECK(row.back() == tests::kStationA);
    auto& line = all.emplace_back();
    for (std::size_t k = 0; k < columns.size(); ++k) line.push_back(row[k].value_or(""));
  }
  return all;
}

/// Numbers are alike to the last bits, since sums are taken in another order.
bool alike(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const auto one = parse_number(a), other = parse_number(b);
  return one && other && *one == Approx(*other).epsilon(1e-12).margin(1e-13);
}

/// Every view of the file, row by row, stands in the archive.
void require_same_answers(const std::filesystem::path& file, const std::string& uri,
                          std::size_t n_accuracies) {
  for (const std::string view :
       {"v_accuracy", "v_point_error", "v_job", "v_drift", "v_point_status", "model"}) {
    CAPTURE(view);
    const Rows own = own_rows(file, view);
    auto theirs = archived_rows(uri, view, own.columns);
    if (view == "v_accuracy") CHECK(own.rows.size() == n_accuracies);
    REQUIRE(own.rows.size() == theirs.size());
    for (const auto& row : own.rows) {
      CAPTURE(row);
      const auto found = std::ranges::find_if(
          theirs, [&row](const auto& their) { return std::ranges::equal(row, their, alike); });
      if (found == theirs.end()) {
        CAPTURE(theirs);
        FAIL_CHECK("the archive has no such row");
      } else {
        theirs.erase(found);
      }
    }
  }
}

/// A campaign of this machine in which everything is odd that a session can be: targets twice, and
/// a little beside themselves; what was stopped, excluded, visited in another order, by name alone;
/// calibrated again, and forced; imported in parts.
class OddCampaign {
 public:
  OddCampaign(store::Connection& db, const char* kind, Coordinates measured) : db_(db) {
    Campaign head;
    head.name = kind;
    head.simulated = true;
    head.machine = starting_machine(kind);
    head.machine.measured = measured;
    head.tracker = {.xy_mm = 0.01, .phi_rad = measured[2] ? 1e-4 : 0};
    machine_ = head.machine;
    campaign_ = store::add_campaign(db, head);
    for (int k = 0; k < 14; ++k) targets_.push_back(target(k % 12));
    walk("fit", targets_, 14);
    walk("stopped", targets_, 5);
    walk("judge", {target(20), target(0), target(21), target(20)}, 4, {}, "", ReadingSet::validate);
    walk("elsewhere, stopped", {target(30), target(31), target(32)}, 2);
    store::exclude_reading(db, campaign_, 3, "a truck passed");
    const store::Id first = calibrate();
    std::vector<Pose> other_order(targets_.rbegin(), targets_.rend());
    for (Pose& pose : other_order) pose.x_mm += 4e-4;  // what text may lose
    walk("again", other_order, 14, first);
    walk("again, stopped", targets_, 9, first);
    store::exclude_reading(db, campaign_, 14, "fog");
    const store::Id second = calibrate();
    calibrate(true);
    walk("again at last", targets_, 14, second);
    walk("judged again", {target(20), target(0), target(21), target(20)}, 4, second);
    store::exclude_reading(db, campaign_, 64, "late");
    walk("by name", targets_, 14, {}, "vendor");
    import("imported", 6, 6, "");
    import("imported again", 6, 6, "table");
    import("imported in part", 4, 6, "table");
  }

 private:
  [[nodiscard]] Pose target(int k) const {
    const double reach = machine_.drives[0].limits.l_max_mm / 8;
    Pose pose = machine_.home;
    pose.x_mm += reach * std::sin(1.0 + 7.0 * k);
    if (machine_.kind->n_chains > 1) pose.y_mm += reach * std::cos(2.0 + 5.0 * k);
    if (!machine_.kind->has_point_platform()) pose.phi_rad += 0.01 * std::sin(3.0 * k);
    return pose;
  }
  [[nodiscard]] store::NewReading seen(const Pose& at, double error) {
    Reading r;
    r.target = at;
    r.conditions.cmd_mm = r.conditions.from_mm = drives_of(machine_, at);
    r.conditions.from_mm[0] -= (n_seen_ % 2) != 0 ? 1 : -1;
    if (n_seen_ % 3 != 0) r.conditions.temp_degc = 20 + 0.1 * n_seen_;
    r.measured = at;
    const auto shift = [&](int c, double by) {
      double& value = c == 0 ? r.measured->x_mm : c == 1 ? r.measured->y_mm : r.measured->phi_rad;
      value = machine_.measured[static_cast<std::size_t>(c)] ? value + by : 0;
    };
    ++n_seen_;
    shift(0, error * std::sin(n_seen_));
    shift(1, error * std::cos(2 * n_seen_));
    shift(2, 0.01 * error * std::sin(3 * n_seen_));
    return {.reading = r};
  }
  void walk(const std::string& name, const std::vector<Pose>& targets, int n_done,
            std::optional<store::Id> job = {}, const std::string& by_name = "",
            ReadingSet set = ReadingSet::identify) {
    std::vector<store::Point> plan;
    for (const Pose& at : targets) {
      plan.push_back({.seq = static_cast<int>(plan.size()) + 1, .set = set, .target = at});
      plan.back().planned_mm = drives_of(machine_, at);
      plan.back().role = plan.size() == 4 ? "reference 1" : "grid";
    }
    const store::Id session = store::create_session(db_, {.campaign_id = campaign_,
                                                          .name = name,
                                                          .compensation_job = job,
                                                          .compensation_name = by_name,
                                                          .plan_name = name,
                                                          .points = plan});
    const auto epoch = store::open_epoch(db_, session, store::SetUp::fresh, "start");
    for (int k = 0; k < n_done; ++k) {
      const int seq = plan[static_cast<std::size_t>(k)].seq;
      if (k == 1)
        store::fail_attempt(db_, store::begin_attempt(db_, session, seq, epoch.id), "fog");
      store::NewReading reading = seen(targets[static_cast<std::size_t>(k)], job ? 0.01 : 0.1);
      reading.reading.set = set;
      store::finish_attempt(db_, store::begin_attempt(db_, session, seq, epoch.id), {reading});
    }
  }
  void import(const std::string& name, int n, int n_asked, const std::string& by_name) {
    const int next = n_seen_ + 1;
    const store::Id session = store::create_session(
        db_, {.campaign_id = campaign_,
              .name = name,
              .compensation_name = by_name,
              .n_imported = n,
              .n_asked = n_asked,
              .settings_json = store::with_roles("{}", {{next + 2, "reference 1"}})});
    store::add_epoch(db_, session, 100 + next, "import");
    std::vector<store::NewReading> readings;
    for (int k = 0; k < n; ++k) {
      readings.push_back(seen(target(40 + k / 2), 0.05));
      readings.back().reading.seq = next + k;
      readings.back().reading.conditions.epoch = 100 + next;
    }
    store::Transaction transaction(db_);
    store::ReadingWriter(db_, campaign_).add_all(readings, session);
    transaction.commit();
  }
  store::Id calibrate(bool force = false) {
    return job::run(db_, {.campaign = std::string(machine_.kind->name),
                          .stage = "geometry",
                          .force = force,
                          .despite_screen = true})
        .job.id;
  }

  store::Connection& db_;
  Machine machine_;
  store::Id campaign_ = 0;
  std::vector<Pose> targets_;
  int n_seen_ = 0;
};

}  // namespace

TEST_CASE("the questions of examples/queries have the same answers in the archive", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::filesystem::path queries =
      std::filesystem::path(tests::source_folder()) / "examples/queries";
  const std::string archive = server->new_archive();
  const tests::TemporaryFolder lab;
  std::filesystem::copy_file(queries / "laboratory.sqlite3", lab.path() / "lab.db");
  REQUIRE(run_program({"db", "migrate", "--db", "lab.db"}, lab.path()).exit_code == 0);
  tests::push_all(server->uri(archive, "robot_a"), lab.path() / "lab.db", tests::kStationA);
  int n_same = 0;
  for (const auto& entry : std::filesystem::directory_iterator(queries)) {
    if (entry.path().extension() != ".sql") continue;
    const std::string sql = read_text(entry.path());
    CAPTURE(entry.path().stem());
    const auto answer = run_program(
        {"query", "--archive", server->uri(archive, "visitor"), sql, "--csv"}, lab.path());
    CAPTURE(answer.err);
    CHECK(answer.out == read_text(queries / (entry.path().stem().string() + ".csv")));
    ++n_same;
  }
  CHECK(n_same == 10);
}

// Row by row and column by column: numbers to the last bit but where sums are taken in another
// order. Of a campaign with every kind of row.
TEST_CASE("the views have the columns and rows of a station's, and its station", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string archive = server->new_archive();
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    store::Connection db = store::open(file, store::Access::create);
    tests::add_full_campaign(db, "rail");
    tests::add_full_campaign(db, "other rail");
    Campaign visits = tests::paper_campaign("visits");
    for (std::size_t k = 7; k < 21; ++k) {  // seven of the points again, twice
      Reading again = visits.readings[k % 7];
      again.seq = visits.readings[k].seq;
      again.measured->x_mm += 1e-3 * static_cast<double>(k);
      visits.readings[k] = again;
    }
    store::import_campaign(db, visits);
    job::run(db, {.campaign = "visits", .stage = "lsq"});
  }
  tests::push_all(server->uri(archive, "robot_a"), file, tests::kStationA);
  require_same_answers(file, server->uri(archive, "visitor"), 10);
}

// Machines that measure no attitude, or one coordinate of three, have no figure of it.
TEST_CASE("the archive answers as a station does, for every kind of machine",
          "[archive][release]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  struct Kind {
    const char* name;
    Coordinates measured;
    std::size_t n_accuracies;
  };
  const auto [name, measured, n_accuracies] =
      GENERATE(Kind{"3-PRR", {true, true, true}, 22}, Kind{"3-PRR", {true, true, false}, 11},
               Kind{"3-PPR", {true, true, true}, 22}, Kind{"3-RPR", {true, true, true}, 22},
               Kind{"XY", {true, true, false}, 11}, Kind{"X", {true, false, false}, 11});
  CAPTURE(name, measured);
  const std::string archive = server->new_archive();
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    store::Connection db = store::open(file, store::Access::create);
    const OddCampaign campaign(db, name, measured);
  }
  tests::push_all(server->uri(archive, "robot_a"), file, tests::kStationA);
  require_same_answers(file, server->uri(archive, "visitor"), n_accuracies);
}
