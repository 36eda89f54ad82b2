#include "tests/store/fixtures.hpp"

#include <unistd.h>

namespace trammel::test {

TempFolder::TempFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "trammel-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Campaign small_campaign(int n, const std::string& name) {
  Campaign c;
  c.name = name;
  c.machine = machine_of(paper_mechanism());
  c.tracker = TrackerSigma{0.01, 7e-5};
  c.facts = {{"instrument", "laser tracker"}, {"operator", "Zoë"}};
  for (int seq = 1; seq <= n; ++seq) {
    const double x_mm = 10.0 * seq;
    Reading r;
    r.seq = seq;
    r.set = seq == n ? ReadingSet::validate : ReadingSet::identify;
    r.target = {x_mm, 0, 0};
    r.conditions = {.cmd_mm = {200.0 + x_mm / 3, 210, 220}, .from_mm = {200, 210, 220.1}};
    if (seq % 2 == 0) r.conditions.temp_degc = 20.0 + 0.1 * seq;
    if (seq % 2 == 0) r.conditions.time_s = 5.0 * seq;
    r.measured = Pose{x_mm + 0.1 / seq, -0.0, 1e-5 * seq};
    c.readings.push_back(r);
  }
  return c;
}

std::vector<store::Point> line_plan(int n) {
  std::vector<store::Point> plan;
  for (int seq = 1; seq <= n; ++seq) {
    plan.push_back({.seq = seq,
                    .target = {5.0 * seq, 1, 0},
                    .approach = {1, -1, 0},
                    .role = "grid",
                    .planned_mm = {200.0 + seq, 201, 202}});
  }
  return plan;
}

store::NewReading reading_at(const store::Point& point) {
  store::NewReading reading;
  reading.reading.set = point.set;
  reading.reading.target = point.target;
  reading.reading.conditions = {.cmd_mm = point.planned_mm,
                                .from_mm = {200, 200, 200},
                                .time_s = 3.5 * point.seq,
                                .temp_degc = 21.25};
  reading.reading.measured =
      Pose{point.target.x_mm + 0.003, point.target.y_mm + 0.004, point.target.phi_rad};
  reading.encoder_mm = point.planned_mm;
  reading.raw_reply = "AP 1 2 3";
  return reading;
}

store::Id measured_session(store::Connection& db, store::Id campaign_id, const std::string& name,
                           int n) {
  const store::Id session =
      store::create_session(db, {.campaign_id = campaign_id, .name = name, .points = line_plan(n)});
  const auto epoch = store::open_epoch(db, session, store::SetUp::fresh, "start");
  for (const store::Point& point : store::open_points(db, session)) {
    const auto attempt = store::begin_attempt(db, session, point.seq, epoch.id);
    store::finish_attempt(db, attempt, {reading_at(point)});
  }
  return session;
}

std::int64_t number(store::Connection& db, std::string_view sql) {
  store::Statement statement(db, sql);
  return statement.step() ? statement.integer(0) : -1;
}

}  // namespace trammel::test
