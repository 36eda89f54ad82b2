// Whoever is asked how accurate a campaign is says the same: calibrate, report, assess, compare and
// v_accuracy. And what they say is of points that no fit has seen, where they say so.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/files/stored_campaign.hpp"
#include "app/job/run.hpp"
#include "app/report/accuracy.hpp"
#include "app/report/assess/assessment.hpp"
#include "app/report/gather.hpp"
#include "app/report/print.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

/// What a speaker says of one set of points.
struct Said {
  bool in_sample = false, predicted = false;
  std::size_t n = 0;
  double before_mm = 0, after_mm = 0;
  bool operator==(const Said&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Said& s) {
  return out << (s.in_sample ? "in-sample " : "held-out ")
             << (s.predicted ? "predicted " : "again ") << s.n << ": " << s.before_mm << " -> "
             << s.after_mm;
}

/// A robot with errors of its own, and a database of what it was seen to do.
struct Laboratory {
  explicit Laboratory(std::uint64_t seed) : random(seed), truth(random_geometry(random)) {
    Campaign head = paper_campaign("lab");
    head.readings.clear();
    campaign = store::add_campaign(db, head);
  }

  /// Walks over the first `n_done` of these targets; corrected ones end near their target.
  void walk(const std::string& session, ReadingSet set, const std::vector<Pose>& targets,
            std::size_t n_done, std::optional<store::Id> compensation = {}) {
    std::vector<store::Point> plan;
    const std::vector<Reading> readings = measure(truth, targets, random);
    for (const Reading& r : readings) {
      plan.push_back({.seq = r.seq, .set = set, .target = r.target, .role = "grid"});
      plan.back().planned_mm = r.conditions.cmd_mm;
    }
    const store::Id id = store::create_session(db, {.campaign_id = campaign,
                                                    .name = session,
                                                    .compensation_job = compensation,
                                                    .plan_name = session,
                                                    .points = plan});
    const store::Epoch epoch =
        store::open_epoch(db, id, first ? store::SetUp::fresh : store::SetUp::as_before, "test");
    first = false;
    for (std::size_t k = 0; k < n_done; ++k) {
      Reading r = readings[k];
      r.seq = 0;
      r.set = set;
      if (compensation) {
        r.measured = Pose{r.target.x_mm + 0.02 * random.normal(),
                          r.target.y_mm + 0.02 * random.normal(), r.target.phi_rad};
      }
      store::finish_attempt(db, store::begin_attempt(db, id, plan[k].seq, epoch.id),
                            {{.reading = r}});
    }
  }

  store::Job calibrate(const std::string& stage) {
    return job::run(db, {.campaign = "lab", .stage = stage}).job;
  }
  report::Report reported() {
    return report::gather(db, store::require_campaign(db, "lab")).report;
  }

  test::TempFolder folder;
  store::Connection db = store::open(folder.file("t.db"), store::Access::create);
  Random random;
  Geometry truth;
  store::Id campaign = 0;
  bool first = true;
};

std::vector<Said> by_report(const report::Report& report, const std::string& method) {
  std::vector<Said> all;
  for (const report::ErrorTable& t : report.tables) {
    if (t.figure != "position" || t.method != method) continue;
    all.push_back({t.in_sample(), t.after_predicted, t.before.n, t.before.mean, t.after.mean});
  }
  return all;
}

std::vector<Said> by_report_json(const report::Report& report, const std::string& method) {
  std::vector<Said> all;
  const auto json = report::to_json(report);
  for (const auto& t : json.at("tables")) {
    if (t.at("figure") != "position" || t.at("method") != method) continue;
    all.push_back({t.at("in_sample"), t.at("after_is") == "predicted", t.at("before").at("n"),
                   t.at("before").at("mean"), t.at("after").at("mean")});
  }
  return all;
}

std::vector<Said> by_assess(Laboratory& lab, store::Id job) {
  std::vector<Said> all;
  const assess::Assessment found =
      assess::gather(lab.db, store::require_campaign(lab.db, "lab"), "", std::to_string(job));
  for (const assess::Judged& j : found.job->sets) {
    if (j.cross_validated) continue;
    all.push_back({j.in_sample(), j.predicted, j.before_mm.n, j.before_mm.mean, j.after_mm.mean});
  }
  return all;
}

std::vector<Said> by_job(const store::Job& job) {
  std::vector<Said> all;
  for (const store::Statistic& s : job.data.statistics) {
    if (s.metric != "position_mm") continue;
    all.push_back(
        {s.in_sample, true, static_cast<std::size_t>(s.before->n), s.before->mean, s.after->mean});
  }
  return all;
}

std::vector<Said> by_view(Laboratory& lab, const std::string& method) {
  store::Connection db = store::open(lab.folder.file("t.db"), store::Access::read_only);
  store::provide(db, report::accuracy(db));
  store::Query query(db,
                     "SELECT in_sample, source = 'predicted', n, before_mean, after_mean "
                     "FROM v_accuracy WHERE metric = 'position_mm' AND method = '" +
                         method + "'",
                     std::chrono::seconds(10));
  std::vector<Said> all;
  while (const auto row = query.next()) {
    all.push_back({std::get<std::int64_t>((*row)[0]) != 0, std::get<std::int64_t>((*row)[1]) != 0,
                   static_cast<std::size_t>(std::get<std::int64_t>((*row)[2])),
                   std::get<double>((*row)[3]), std::get<double>((*row)[4])});
  }
  return all;
}

/// Each that `some` says, `all` says too.
void check_within(const std::vector<Said>& some, const std::vector<Said>& all) {
  for (const Said& s : some) {
    CAPTURE(s, all);
    CHECK(std::ranges::find(all, s) != all.end());
  }
}

std::size_t n_of(const std::vector<Said>& all, bool in_sample, bool predicted) {
  std::size_t n = 0;
  for (const Said& s : all) {
    if (s.in_sample == in_sample && s.predicted == predicted) n += s.n;
  }
  return n;
}

}  // namespace

TEST_CASE("all speakers print the same n, mean and set, for any campaign", "[report][judge]") {
  constexpr std::uint64_t kCampaigns = 4;
  for (std::uint64_t seed = 1; seed <= kCampaigns; ++seed) {
    CAPTURE(seed);
    Laboratory lab(seed);
    const auto n_fitted = static_cast<std::size_t>(lab.random.uniform(30, 60));
    const auto n_new = static_cast<std::size_t>(lab.random.uniform(6, 20));
    const auto n_old = static_cast<std::size_t>(lab.random.uniform(1, 9));
    std::vector<Pose> fitted, others;
    for (std::size_t k = 0; k < n_fitted; ++k) {
      fitted.push_back({lab.random.uniform(-80, 80), lab.random.uniform(-80, 80),
                        lab.random.uniform(-0.05, 0.05)});
    }
    for (std::size_t k = 0; k < n_new; ++k) {
      others.push_back({lab.random.uniform(-60, 60), lab.random.uniform(-60, 60), 0});
    }
    // Fitted targets that went through text, and fitted places in another orientation.
    for (std::size_t k = 0; k < n_old; ++k) {
      others.push_back(
          {fitted[k].x_mm + lab.random.uniform(-5e-4, 5e-4), fitted[k].y_mm, fitted[k].phi_rad});
      others.push_back({fitted[k].x_mm, fitted[k].y_mm, fitted[k].phi_rad + 0.02});
    }
    const std::size_t n_unseen = n_new + n_old;
    lab.walk("fit", ReadingSet::identify, fitted, n_fitted);
    lab.walk("judge", ReadingSet::validate, others, others.size());
    lab.walk("judge again", ReadingSet::validate, others, 2);  // stopped
    const store::Job lsq = lab.calibrate("lsq"), idw = lab.calibrate("idw");

    for (const store::Job* job : {&lsq, &idw}) {
      const std::string method = job->data.stage;
      CAPTURE(method);
      const report::Report report = lab.reported();
      const std::vector<Said> said = by_report(report, method), view = by_view(lab, method);
      CHECK(n_of(said, false, true) == n_unseen);
      CHECK(by_report_json(report, method) == said);
      check_within(said, by_assess(lab, job->id));
      check_within(by_job(*job), view);
      check_within(by_job(*job), by_assess(lab, job->id));
      if (method == "lsq") {  // the headline's
        check_within(by_job(*job), said);
        const auto assessed = assess::gather(lab.db, store::require_campaign(lab.db, "lab"), "",
                                             std::to_string(job->id));
        CHECK(combined_mm(report.budget) == combined_mm(assessed.job->budget));
        CHECK(combined_mm(report.budget) > 0);
      }
      CHECK(view.size() == by_job(*job).size());
      // The session that was stopped repeats two of the new points: it judges nothing.
      CHECK(n_of(by_job(*job), false, true) == n_unseen);
      CHECK(n_of(by_job(*job), true, true) == n_fitted + n_old);
    }

    // Measured again: complete, then once more but stopped, then without a reading.
    lab.walk("again", ReadingSet::validate, others, others.size(), idw.id);
    const std::vector<Said> whole = by_report(lab.reported(), "idw");
    CHECK(n_of(whole, false, false) == n_unseen);
    CHECK(n_of(whole, true, false) == n_old);
    CHECK(n_of(whole, false, true) == 0);
    const auto check_all = [&] {
      const report::Report report = lab.reported();
      CHECK(by_report(report, "idw") == whole);
      CHECK(by_report_json(report, "idw") == whole);
      check_within(whole, by_assess(lab, idw.id));
      std::vector<Said> view = by_view(lab, "idw");
      std::erase_if(view, [](const Said& s) { return s.predicted; });
      CHECK(view.size() == whole.size());
      check_within(whole, view);
      return report;
    };
    check_all();
    lab.walk("stopped", ReadingSet::validate, others, 3, idw.id);
    CHECK_THAT(
        report::to_text(check_all(), {}),
        Contains("session stopped has measured 3 of " + std::to_string(others.size()) + " points"));
    lab.walk("nothing", ReadingSet::validate, others, 0, idw.id);
    check_all();

    if (seed < kCampaigns) continue;  // the same tables, through the program
    const Finished compared =
        run_program({"compare", "lab", "lab", "--json", "--db", lab.folder.file("t.db").string()},
                    lab.folder.path());
    REQUIRE(compared.exit_code == 0);
    std::vector<Said> sides;
    const auto json = nlohmann::json::parse(compared.out);
    for (const auto& t : json.at("tables")) {
      if (!t.at("id").get<std::string>().starts_with("idw-") || t.at("unit") != "mm") continue;
      const auto& a = t.at("a");
      sides.push_back({t.at("in_sample"), a.at("after_is") == "predicted", a.at("n"),
                       a.at("before_mean"), a.at("after_mean")});
    }
    CHECK(sides == whole);
  }
}

TEST_CASE("validation rows that copy fitted ones are not unseen, and no headline rests on them",
          "[report][judge]") {
  Laboratory lab(5);
  const std::vector<Pose> targets = eighty_points();
  lab.walk("fit", ReadingSet::identify, targets, targets.size());
  lab.walk("copies", ReadingSet::validate, targets, targets.size());
  lab.calibrate("idw");
  const report::Report report = lab.reported();
  CHECK(report.tables.empty());
  CHECK_THAT(report::verdict(report), !Contains("unseen") && Contains("none that judges"));
  lab.calibrate("lsq");
  for (const Said& s : by_report(lab.reported(), "lsq")) CHECK(s.in_sample);
  CHECK_THAT(report::verdict(lab.reported()), Contains("fitted points"));
}

TEST_CASE("validation in an epoch that no fit has seen is told as that, and judges nothing",
          "[report][judge]") {
  Campaign campaign = paper_campaign();
  for (Reading& r : campaign.readings) {  // homed and framed anew
    if (r.set != ReadingSet::validate) continue;
    r.conditions.epoch = 2;
    r.measured->x_mm += 0.4;
  }
  test::TempFolder folder;
  store::Connection db = store::open(folder.file("t.db"), store::Access::create);
  store::import_campaign(db, campaign);
  for (const char* stage : {"lsq", "rbf", "diagnose"}) {
    CAPTURE(stage);
    const store::Job job = job::run(db, {.campaign = "paper", .stage = stage}).job;
    CHECK_THAT(job.data.result_json, Contains("were measured in epoch 2, of which no reading"));
    const auto apart =
        std::ranges::find(job.data.statistics, job::kNewEpoch, &store::Statistic::set);
    REQUIRE(apart != job.data.statistics.end());
    CHECK(apart->before->n == 48);
    for (const store::Statistic& s : job.data.statistics) CHECK(s.set != "validate");
    const assess::Assessment found =
        assess::gather(db, store::require_campaign(db, "paper"), "", std::to_string(job.id));
    for (const assess::Judged& j : found.job->sets) {
      if (j.standing != Standing::unknown_epoch) continue;
      CHECK_FALSE(j.improvement_pct);
      CHECK_FALSE(j.covered_pct);
    }
  }
  const report::Report report = report::gather(db, store::require_campaign(db, "paper")).report;
  for (const report::ErrorTable& t : report.tables) {
    CHECK(t.improvement_pct.has_value() == (t.standing != Standing::unknown_epoch));
  }
  CHECK_THAT(report::verdict(report), Contains("80 fitted points"));
  const std::string text = report::to_text(report, {});
  CHECK_THAT(text, Contains("new epoch") && Contains("were measured in epoch 2") &&
                       !Contains("makes position worse"));
}

TEST_CASE("a resume whose reference points hold lets a fit know its epoch; they are not fitted",
          "[report][judge]") {
  Laboratory lab(6);
  lab.walk("fit", ReadingSet::identify, eighty_points(), 80);
  std::vector<Pose> others;
  for (int k = 0; k < 10; ++k) others.push_back({7.0 * k - 33, 11, 0});
  lab.walk("judge", ReadingSet::validate, others, 4);
  // As the runner does it: the references in a session of their own, then on under their epoch.
  const store::Id references = store::create_session(
      lab.db,
      {.campaign_id = lab.campaign,
       .name = "judge, reference 1",
       .plan_name = store::kReferencePlan,
       .points = {
           {.seq = 1, .target = others[0], .reference = true, .role = "reference to point 1"}}});
  const store::Epoch epoch =
      store::open_epoch(lab.db, references, store::SetUp::fresh, "reference points of judge");
  Reading again = measure(lab.truth, {others[0]}, lab.random)[0];
  again.seq = 0;
  store::finish_attempt(lab.db, store::begin_attempt(lab.db, references, 1, epoch.id),
                        {{.reading = again}});
  const store::SessionRow row = *store::find_session(lab.db, lab.campaign, "judge");
  const store::Id resumed = store::add_epoch(lab.db, row.id, epoch.number, store::kReferencesHold);
  for (const store::Point& point : store::open_points(lab.db, row.id)) {
    Reading r = measure(lab.truth, {point.target}, lab.random)[0];
    r.seq = 0;
    r.set = ReadingSet::validate;
    store::finish_attempt(lab.db, store::begin_attempt(lab.db, row.id, point.seq, resumed),
                          {{.reading = r}});
  }
  const store::Job idw = lab.calibrate("idw");
  CHECK(idw.data.n_readings == 90);
  CHECK(by_job(idw)[0].n == 80);  // the reference visit is no identify row
  CHECK(by_job(idw)[1].n == 10);
  CHECK(n_of(by_report(lab.reported(), "idw"), false, true) == 10);
}

TEST_CASE("the headline's method is chosen by a rule, never by the least error it leaves",
          "[report][judge]") {
  const auto table = [](const char* method, Standing standing, bool predicted, double after_mm) {
    report::ErrorTable t{.id = method, .method = method, .figure = "position", .unit = "mm"};
    t.standing = standing;
    t.after_predicted = predicted;
    for (int k = 0; k < 6; ++k) t.points.push_back({1.0 * k, 0, 0.2, after_mm + 0.001 * k});
    t.before = {.n = 6, .mean = 0.2};
    t.after = {.n = 6, .mean = after_mm};
    t.improvement_pct = improvement_pct(t.before, t.after);
    return t;
  };
  report::Report r;
  const auto says = [&r](const std::string& words) {
    CHECK_THAT(report::verdict(r), Contains(words));
  };
  r.tables = {table("idw", Standing::unseen, true, 0.01),
              table("lsq", Standing::unseen, true, 0.05),
              table("lsq", Standing::fitted, false, 0.001)};
  says("6 unseen points least squares");
  r.tables.push_back(table(report::kModel, Standing::unseen, true, 0.06));
  says("least squares");
  r.story.push_back({.verdict = "explained",
                     .effects = {{.name = "lead_scale"}},
                     .rivals = {{.names = "backlash"}}});
  says("the geometry with the named effects");
  says("Other sets of effects explain the readings about as well");
  r.picked = "gp";
  r.tables.push_back(table("contest", Standing::unseen, true, 0.07));
  says("gp, the contest's pick,");
  r.tables.push_back(table("rbf", Standing::unseen, false, 0.08));  // measured again
  says("the radial basis network");
  says("95 % interval");
  r.tables.insert(r.tables.begin(), table("idw", Standing::unseen, false, 0.07));
  says("the radial basis network");  // whatever the order, and what is left
  r.tables = {table("lsq", Standing::unknown_epoch, true, 0.01)};
  says("none that judges");
}

TEST_CASE("a campaign that went through its files is judged alike, and leaves them as it came",
          "[report][judge]") {
  for (const std::uint64_t seed : {11UL, 12UL, 13UL}) {
    INFO("seed " << seed);
    Laboratory lab(seed);
    lab.walk("fit", ReadingSet::identify, eighty_points(), 80);
    std::vector<Pose> others, circle;
    for (int k = 0; k < 12; ++k) others.push_back({7.0 * k - 33, 11.0 + k, 0});
    for (int k = 0; k < 9; ++k)
      circle.push_back({30 * std::cos(0.7 * k), 30 * std::sin(0.7 * k), 0});
    lab.walk("judge", ReadingSet::validate, others, 12);
    lab.walk("judge, stopped", ReadingSet::validate, others, 5);
    const store::Job lsq = lab.calibrate("lsq"), idw = lab.calibrate("idw");
    lab.walk("fit again", ReadingSet::identify, eighty_points(), 80, lsq.id);
    lab.walk("judge again", ReadingSet::validate, others, 12, lsq.id);
    lab.walk("judge by idw", ReadingSet::validate, others, 12, idw.id);
    lab.walk("judge by idw, stopped", ReadingSet::validate, others, 7, idw.id);
    lab.walk("circle", ReadingSet::validate, circle, 9);
    store::exclude_reading(lab.db, lab.campaign, 85, "bumped");
    const report::Report here = lab.reported();

    const auto row = store::require_campaign(lab.db, "lab");
    const auto out = lab.folder.file("out"), again = lab.folder.file("again");
    write_campaign(stored_campaign(lab.db, row), out);
    store::Connection elsewhere = store::open(lab.folder.file("other.db"), store::Access::create);
    CHECK_FALSE(store_campaign(elsewhere, read_campaign(out)).already_stored);
    CHECK(store_campaign(elsewhere, read_campaign(out)).already_stored);
    const auto copy = store::require_campaign(elsewhere, "lab");
    write_campaign(stored_campaign(elsewhere, copy), again);
    for (const char* name : {"campaign.json", "readings.csv"}) {
      CHECK(read_text(out / name) == read_text(again / name));
    }
    const report::Report there = report::gather(elsewhere, copy).report;
    for (const char* method : {"lsq", "idw"}) {
      INFO(method);
      std::vector<Said> measured = by_report(here, method);
      std::erase_if(measured, [](const Said& s) { return s.predicted; });
      CHECK(measured.size() >= 1);
      CHECK(by_report(there, method) == measured);
    }
    REQUIRE(there.sessions.size() == here.sessions.size());
    for (std::size_t k = 0; k < here.sessions.size(); ++k) {
      INFO(here.sessions[k].name);
      CHECK(there.sessions[k].name == here.sessions[k].name);
      CHECK(there.sessions[k].plan == here.sessions[k].plan);
      CHECK(there.sessions[k].n_points == here.sessions[k].n_points);
      CHECK(there.sessions[k].n_done == here.sessions[k].n_done);
      CHECK(there.sessions[k].counts == here.sessions[k].counts);
      CHECK(there.sessions[k].compensation.empty() == here.sessions[k].compensation.empty());
    }
    CHECK(there.exclusions == here.exclusions);
    // And it can be calibrated there: to the same values.
    const auto values = [](const store::Job& job) {
      return nlohmann::json::parse(job.data.result_json).at("correction").flatten();
    };
    const nlohmann::json a = values(job::run(elsewhere, {.campaign = "lab", .stage = "lsq"}).job);
    const nlohmann::json b = values(lab.calibrate("lsq"));
    for (const auto& [path, value] : b.items()) {
      INFO(path);  // not every angle in rad is one in deg to the last bit
      if (value.is_number())
        CHECK(a.at(path).get<double>() == Approx(value.get<double>()).margin(1e-12));
    }
  }
}
