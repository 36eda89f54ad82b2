#include "store/query.hpp"

#include <cmath>

#include "store/job.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;
using namespace std::chrono_literals;
using trammel::test::TempFolder;

namespace {

struct Lab {
  Lab() : writer(store::open(folder.file("lab.db"), Access::create)) {}
  std::vector<std::vector<Cell>> ask(const std::string& sql) {
    Connection db = store::open(folder.file("lab.db"), Access::read_only);
    Query query(db, sql, 5s);
    std::vector<std::vector<Cell>> rows;
    while (auto row = query.next()) rows.push_back(*std::move(row));
    return rows;
  }
  TempFolder folder;
  Connection writer;
};

double real(const Cell& cell) { return std::get<double>(cell); }

}  // namespace

TEST_CASE("a question is answered with its types, while a writer is at work", "[store]") {
  Lab lab;
  import_campaign(lab.writer, test::small_campaign());
  const auto rows = lab.ask("SELECT name, 1 + 1, 0.5, NULL, x'ff' FROM campaign; -- so");
  REQUIRE(rows.size() == 1);
  CHECK(std::get<std::string>(rows[0][0]) == "rail-test");
  CHECK(std::get<std::int64_t>(rows[0][1]) == 2);
  CHECK(real(rows[0][2]) == 0.5);
  CHECK(std::holds_alternative<std::nullptr_t>(rows[0][3]));
  CHECK(std::get<std::string>(rows[0][4]) == "ff");
}

TEST_CASE("anything but one SELECT is refused", "[store]") {
  Lab lab;
  for (const char* sql :
       {"", "-- nothing", "SELECT 1; SELECT 2", "INSERT INTO campaign_fact VALUES (1, 'a', 'b')",
        "DELETE FROM reading", "DROP TABLE reading", "ATTACH '/tmp/x.db' AS x", "VACUUM",
        "PRAGMA query_only = OFF", "PRAGMA journal_mode = DELETE", "SELEKT 1",
        "SELECT load_extension('x')", "CREATE TEMP TABLE t (x)", "SELECT nothing FROM campaign"}) {
    INFO(sql);
    CHECK_THROWS_AS(lab.ask(sql), InputError);
  }
}

TEST_CASE("a question without an end is stopped when its time is over", "[store]") {
  Lab lab;
  Connection db = store::open(lab.folder.file("lab.db"), Access::read_only);
  Query query(db,
              "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
              "SELECT count(*) FROM n",
              100ms);
  const auto start = std::chrono::steady_clock::now();
  CHECK_THROWS_WITH(query.next(), Contains("too long"));
  CHECK(std::chrono::steady_clock::now() - start < 5s);
}

TEST_CASE("v_accuracy pairs a compensated session with the baseline of the same targets",
          "[store]") {
  Lab lab;
  const Id campaign = add_campaign(lab.writer, test::small_campaign());
  const Id baseline = test::measured_session(lab.writer, campaign, "baseline", 4);
  NewJob job{.campaign_id = campaign, .key = {std::string(64, 'a'), {}}, .stage = "idw"};
  job.sessions = {baseline};
  job.result_json =
      R"({"points":{"in_sample":[1,1],"phi_rad":[0.0,0.0],"seq":[1,2],"x_mm":[0.0,0.0],"y_mm":[0.0,0.0]}})";
  job.statistics = {{.set = "identify",
                     .metric = "position_mm",
                     .in_sample = true,
                     .before = Summary{0.2, 0.4, 0.1, 0.3, 2},
                     .after = Summary{0.05, 0.1, 0, 0.1, 2}}};
  const Id job_id = add_job(lab.writer, job);
  const Id session = create_session(lab.writer, {.campaign_id = campaign,
                                                 .name = "again",
                                                 .compensation_job = job_id,
                                                 .points = test::line_plan(4)});
  const Epoch epoch = open_epoch(lab.writer, session, SetUp::as_before, "same");
  for (const Point& point : points(lab.writer, session)) {
    NewReading reading = test::reading_at(point);
    // 1, 2, 3, 4 um off, where the baseline was 5 um off everywhere.
    reading.reading.measured = Pose{point.target.x_mm + 0.001 * point.seq, point.target.y_mm, 0};
    finish_attempt(lab.writer, begin_attempt(lab.writer, session, point.seq, epoch.id), {reading});
  }
  const auto measured = lab.ask(
      "SELECT in_sample, n, before_mean, before_p95, after_mean, after_max, after_p95, "
      "improvement_pct FROM v_accuracy WHERE source = 'measured' AND metric = 'position_mm' AND "
      "method = 'idw' AND session = 'again' ORDER BY in_sample DESC");
  REQUIRE(measured.size() == 2);
  const auto& fitted = measured[0];
  CHECK((std::get<std::int64_t>(fitted[0]) == 1 && std::get<std::int64_t>(fitted[1]) == 2));
  constexpr double kRoundingMm = 1e-12;  // differences of coordinates of some 10 mm
  CHECK_THAT(real(fitted[2]), WithinAbs(0.005, kRoundingMm));
  CHECK_THAT(real(fitted[3]), WithinAbs(0.005, kRoundingMm));
  CHECK_THAT(real(fitted[4]), WithinAbs(0.0015, kRoundingMm));
  CHECK_THAT(real(fitted[5]), WithinAbs(0.002, kRoundingMm));
  CHECK_THAT(real(fitted[6]), WithinAbs(0.00195, kRoundingMm));  // 1 + 0.95 (2 - 1) um
  CHECK_THAT(real(fitted[7]), WithinAbs(70, 1e-6));
  CHECK(std::get<std::int64_t>(measured[1][0]) == 0);
  CHECK_THAT(real(measured[1][4]), WithinAbs(0.0035, kRoundingMm));
  const auto predicted =
      lab.ask("SELECT improvement_pct FROM v_accuracy WHERE source = 'predicted'");
  REQUIRE(predicted.size() == 1);
  CHECK_THAT(real(predicted[0][0]), WithinAbs(75, 1e-9));
}

TEST_CASE("v_accuracy takes before from the session that shares most targets, not from later walks",
          "[store]") {
  Lab lab;
  const Id campaign = add_campaign(lab.writer, test::small_campaign());
  test::measured_session(lab.writer, campaign, "baseline", 4);
  const Id job_id = add_job(
      lab.writer, {.campaign_id = campaign, .key = {std::string(64, 'a'), {}}, .stage = "idw"});
  const auto walk = [&](const std::string& name, std::optional<Id> job, int n, double error_mm) {
    const Id session = create_session(lab.writer, {.campaign_id = campaign,
                                                   .name = name,
                                                   .compensation_job = job,
                                                   .points = test::line_plan(n)});
    const Epoch epoch = open_epoch(lab.writer, session, SetUp::as_before, "same");
    for (const Point& point : points(lab.writer, session)) {
      NewReading reading = test::reading_at(point);
      reading.reading.measured = Pose{point.target.x_mm + error_mm, point.target.y_mm, 0};
      finish_attempt(lab.writer, begin_attempt(lab.writer, session, point.seq, epoch.id),
                     {reading});
    }
  };
  walk("again", job_id, 4, 0.001);
  const std::string sql =
      "SELECT before_mean, n FROM v_accuracy WHERE source = 'measured' AND metric = 'position_mm'";
  const auto first = lab.ask(sql);
  walk("two of them", std::nullopt, 2, 0.5);
  const auto later = lab.ask(sql);
  REQUIRE((first.size() == 1 && later.size() == 1));
  CHECK_THAT(real(first[0][0]), WithinAbs(0.005, 1e-12));
  CHECK(real(later[0][0]) == real(first[0][0]));
  CHECK(std::get<std::int64_t>(later[0][1]) == 4);
}

TEST_CASE("v_drift shows what moved since the first visit, v_point_status what is left to do",
          "[store]") {
  Lab lab;
  const Id campaign = add_campaign(lab.writer, test::small_campaign());
  std::vector<Point> plan = test::line_plan(3);
  plan[2] = plan[0];
  plan[2].seq = 3;
  plan[2].reference = true;
  const Id session =
      create_session(lab.writer, {.campaign_id = campaign, .name = "s", .points = plan});
  const Epoch epoch = open_epoch(lab.writer, session, SetUp::fresh, "start");
  for (const int seq : {1, 3}) {
    NewReading reading = test::reading_at(plan[static_cast<std::size_t>(seq - 1)]);
    reading.reading.measured->x_mm += seq == 3 ? 0.25 : 0;
    finish_attempt(lab.writer, begin_attempt(lab.writer, session, seq, epoch.id), {reading});
  }
  const auto drift = lab.ask("SELECT visit, drift_x_mm, is_reference FROM v_drift ORDER BY visit");
  REQUIRE(drift.size() == 2);
  CHECK(real(drift[0][1]) == 0);
  CHECK_THAT(real(drift[1][1]), WithinAbs(0.25, 1e-12));
  CHECK(std::get<std::int64_t>(drift[1][2]) == 1);
  const auto status = lab.ask("SELECT status FROM v_point_status ORDER BY seq");
  REQUIRE(status.size() == 3);
  CHECK(std::get<std::string>(status[0][0]) == "ok");
  CHECK(std::get<std::string>(status[1][0]) == "planned");
}
