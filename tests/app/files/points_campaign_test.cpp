#include "app/files/points_campaign.hpp"

#include <fmt/format.h>

#include "app/files/mechanism_json.hpp"
#include "app/files/plan_json.hpp"
#include "app/files/points_rows.hpp"
#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/nests.hpp"
#include "tests/support/paths.hpp"

using namespace trammel;

namespace {

const std::string kExamples = tests::source_folder() + "/examples/";

PointsCampaign example(const std::string& layout_file, const std::string& points_file) {
  const Layout layout = read_layout(kExamples + "tracker-files/" + layout_file);
  return campaign_of_points(read_points(kExamples + "tracker-files/" + points_file, layout.points),
                            layout, read_mechanism_file(kExamples + "paper/robot.json"),
                            read_plan(kExamples + "tracker-files/plan.json"));
}

/// The made-up robot of scripts/make_tracker_files.py.
Pose stands_at(const Pose& t) {
  return {t.x_mm + 0.0010 * t.x_mm, t.y_mm - 0.0005 * t.y_mm, t.phi_rad + 2e-5 * t.x_mm};
}

const DroppedRow* dropped_at(const PointsCampaign& made, int line) {
  for (const DroppedRow& d : made.poses.dropped) {
    if (std::find(d.lines.begin(), d.lines.end(), line) != d.lines.end()) return &d;
  }
  return nullptr;
}

/// A platform and a tracker of a test's own: rows by order, base nests or none.
struct Bench {
  Layout layout;
  Plan plan{.name = "bench", .approach_mm = 5, .points = {}};
  Mechanism mechanism = paper_mechanism();
  Eigen::Isometry3d T_T_B = Eigen::Isometry3d::Identity();
  Random random{7};
  PointsFile file{.name = "bench.txt", .format = "matrix", .unit = "mm"};

  explicit Bench(int n_poses) {
    T_T_B.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.1, 0, 1).normalized()).matrix();
    T_T_B.translation() << 2000, -500, 300;
    layout.file = "layout.json";
    layout.name = "bench";
    layout.sigma_mm = 0.005;
    layout.body.body = tests::triangle(150);
    layout.frame.from = FrameFrom::base_nests;
    layout.frame.base = {{"B1", {-450, -300, 0}}, {"B2", {450, -300, 0}}, {"B3", {0, 500, 0}}};
    layout.rows.nests = {"P1", "P2", "P3"};
    layout.rows.base_every = 4;
    for (int k = 0; k < n_poses; ++k) {
      plan.points.push_back({.seq = k + 1, .target = {10.0 * (k % 5), 10.0 * (k / 5), 0}});
    }
  }

  void add(const Eigen::Vector3d& in_base) {
    PointRow row;
    row.line = static_cast<int>(file.rows.size()) + 1;
    row.at_mm = T_T_B * in_base + tests::noise_mm(random, layout.sigma_mm);
    row.raw = fmt::format("row {}", row.line);
    file.rows.push_back(row);
  }
  void add_base() {
    for (const NestPoint& nest : layout.frame.base) add(nest.at_mm);
  }
  void add_pose(const Pose& pose) {
    for (const NestPoint& p : tests::seen_at(pose, layout.body)) add(p.at_mm);
  }
  /// All rows as the layout has them; `before_pose` may move things.
  template <class BeforePose>
  void measure(const BeforePose& before_pose) {
    add_base();
    for (const PlannedPoint& p : plan.points) {
      before_pose(p.seq);
      for (int repeat = 0; repeat < layout.rows.repeats; ++repeat) add_pose(p.target);
      const int every = layout.rows.base_every;
      const bool last = p.seq == static_cast<int>(plan.points.size());
      if (every > 0 && (p.seq % every == 0 || last)) add_base();
    }
  }
  PointsCampaign campaign() { return campaign_of_points(file, layout, mechanism, plan); }
};

const auto kNothing = [](int) {};

}  // namespace

TEST_CASE("an export of SpatialAnalyzer becomes readings of what the platform did", "[points]") {
  const PointsCampaign made = example("spatialanalyzer.layout.json", "spatialanalyzer.txt");
  const Campaign& c = made.file.campaign;
  CHECK(c.readings.size() == 24);  // of 25 poses: one has a ghost
  CHECK(c.simulated);
  CHECK(made.started == "2025-02-13T09:00:04");
  CHECK(c.facts.at("points_frame") == "A::WORLD");
  for (const Reading& r : c.readings) {
    const Eigen::Vector3d off = r.measured->vector() - stands_at(r.target).vector();
    CHECK(off.head<2>().norm() < 0.025);  // frame and noise of 5 um: five sigma
    CHECK(std::abs(off[2]) < 2e-4);
    CHECK(r.conditions.time_s.has_value());
    const InverseResult cmd = inverse(mechanism_of(c.machine).geometry, r.target);
    CHECK((r.conditions.cmd_mm - cmd.l_mm).norm() == 0);
  }
  CHECK(c.readings[4].set == ReadingSet::validate);
  CHECK_THAT(c.tracker->xy_mm, WithinRel(0.005 / std::sqrt(3.0), 1e-9));
  CHECK_THAT(c.tracker->phi_rad, WithinAbs(33e-6, 0.5e-6));
}

TEST_CASE("what was left out is named by line: a miss, and the pose that a ghost spoils",
          "[points]") {
  const PointsCampaign made = example("spatialanalyzer.layout.json", "spatialanalyzer.txt");
  REQUIRE(made.poses.dropped.size() == 2);
  CHECK(made.poses.dropped[0].lines == std::vector<int>{26});
  CHECK(made.poses.dropped[0].why == "miss (zero)");
  CHECK(made.poses.dropped[1].lines == std::vector<int>{55, 56, 57});
  CHECK_THAT(made.poses.dropped[1].why, Contains("pose 16") && Contains("not rigid"));
  // Pose 7 has two nests left, and is a reading of them: its raw text has two lines.
  const std::string& raw = made.raw_reply.at(7);
  CHECK_THAT(raw, Contains("Pose07,  P1") && Contains("Pose07,  P3") && !Contains("P2"));
}

TEST_CASE("Leica's file by order: zeroed at home, two readings a pose, a deleted row left out",
          "[points]") {
  const PointsCampaign made = example("leica.layout.json", "leica.csv");
  const Campaign& c = made.file.campaign;
  CHECK(c.readings.size() == 50);
  CHECK(c.readings[0].measured->vector().norm() < 1e-9);  // the first pose at home is the zero
  double square = 0;
  for (const Reading& r : c.readings) {
    const Eigen::Vector3d off = r.measured->vector() - stands_at(r.target).vector();
    square += off.head<2>().squaredNorm() / (2.0 * static_cast<double>(c.readings.size()));
    CHECK(r.conditions.temp_degc.has_value());
  }
  CHECK(std::sqrt(square) < 0.01);  // sigma / sqrt 3 of a pose, and of the one it was zeroed at
  CHECK(c.readings[0].conditions.cmd_mm == c.readings[1].conditions.cmd_mm);
  CHECK(c.readings[0].conditions.from_mm == c.readings[1].conditions.from_mm);
  REQUIRE(made.poses.dropped.size() == 1);
  CHECK(made.poses.dropped[0].why == "miss (deleted)");
}

TEST_CASE("base nests that hold still are said to; the frame stays", "[points]") {
  Bench bench(20);
  bench.measure(kNothing);
  const PointsCampaign made = bench.campaign();
  CHECK(made.file.campaign.readings.size() == 20);
  REQUIRE(made.poses.drifts.size() == 5);
  for (const DriftSeen& d : made.poses.drifts) {
    CHECK_FALSE(d.drift.moved);
    CHECK(d.epoch == 1);
  }
  CHECK(made.poses.dropped.empty());
  CHECK(made.raw_reply.at(1) == "row 4\nrow 5\nrow 6");
}

TEST_CASE("a tracker that was knocked opens an epoch and is registered anew", "[points]") {
  Bench bench(12);
  bench.measure([&](int seq) {
    if (seq == 5) bench.T_T_B.translation().x() += 0.3;
  });
  const PointsCampaign made = bench.campaign();
  REQUIRE(made.poses.drifts.size() == 3);
  CHECK_FALSE(made.poses.drifts[0].drift.moved);
  CHECK(made.poses.drifts[1].drift.moved);
  CHECK_THAT(made.poses.drifts[1].drift.largest_mm, WithinAbs(0.3, 0.05));
  CHECK(made.poses.drifts[1].epoch == 2);
  CHECK_FALSE(made.poses.drifts[2].drift.moved);
  const auto& readings = made.file.campaign.readings;
  CHECK(readings[7].conditions.epoch == 1);
  CHECK(readings[8].conditions.epoch == 2);
  CHECK((readings[11].measured->vector() - readings[11].target.vector()).head<2>().norm() < 0.03);
}

TEST_CASE("one base nest that moved alone registers nothing and is named", "[points]") {
  Bench bench(8);
  bench.measure(kNothing);
  bench.file.rows[16].at_mm.z() += 40;  // base visit after pose 4: rows 16, 17, 18
  const PointsCampaign made = bench.campaign();
  CHECK(made.poses.drifts.size() == 1);
  REQUIRE(made.poses.dropped.size() == 1);
  CHECK(made.poses.dropped[0].lines == std::vector<int>{16, 17, 18});
  CHECK_THAT(made.poses.dropped[0].why, Contains("no longer fit"));
  CHECK(made.file.campaign.readings.size() == 8);
}

TEST_CASE("an outlier among repeats is found by its place, a far pose by its target", "[points]") {
  Bench bench(6);
  bench.layout.rows.repeats = 6;
  bench.layout.rows.base_every = 0;
  bench.measure([&](int seq) {
    if (seq == 4) bench.plan.points[3].target.x_mm += 30;  // the stage went elsewhere
    if (seq == 5) bench.plan.points[3].target.x_mm -= 30;
  });
  bench.file.rows[5].at_mm.y() += 0.45;  // pose 1, repeat 1, P3
  const PointsCampaign made = bench.campaign();
  CHECK(made.file.campaign.readings.size() == 30);  // pose 1's repeat keeps two nests
  const DroppedRow* row = dropped_at(made, 6);
  REQUIRE(row != nullptr);
  CHECK_THAT(row->why, Contains("gross outlier: 0.4") && Contains("limit"));
  const DroppedRow* far = dropped_at(made, 3 + 3 * 18 + 1);
  REQUIRE(far != nullptr);
  CHECK_THAT(far->why, Contains("pose 4") && Contains("mm from its target"));
}

TEST_CASE("samples of one standing become one reading of their mean", "[points]") {
  Bench bench(5);
  bench.layout.rows.repeats = 8;
  bench.layout.rows.mean_of_samples = true;
  bench.layout.rows.base_every = 0;
  bench.measure(kNothing);
  const PointsCampaign made = bench.campaign();
  REQUIRE(made.file.campaign.readings.size() == 5);
  CHECK(std::count(made.raw_reply.at(1).begin(), made.raw_reply.at(1).end(), '\n') == 23);
}

TEST_CASE("nests that are not the layout's are refused, with the sides as they were seen",
          "[points]") {
  Bench bench(6);
  bench.measure(kNothing);
  bench.layout.body.body = tests::triangle(150.2);
  CHECK_THROWS_WITH(bench.campaign(), Contains("P1-P2 -0.") && Contains("6 of 6 poses"));
  bench.layout.body.body = tests::triangle(150);
  std::swap(bench.layout.body.body[0].at_mm, bench.layout.body.body[1].at_mm);
  CHECK_THROWS_WITH(bench.campaign(), Contains("mirror") && Contains("swapped"));
  bench.layout.body.body = tests::triangle(150);
  std::swap(bench.layout.frame.base[0].at_mm, bench.layout.frame.base[2].at_mm);
  CHECK_THROWS_WITH(bench.campaign(), Contains("base nests do not stand"));
}

TEST_CASE("a missing row is found by its turn, or by the count, and says what was expected",
          "[points]") {
  Bench bench(6);
  bench.measure(kNothing);
  bench.file.rows.pop_back();
  CHECK_THROWS_WITH(bench.campaign(), Contains("got '26'") || Contains("got 26"));
  CHECK_THROWS_WITH(bench.campaign(), Contains("27 = 6 poses x 1 repeats x 3 nests + 3 x 3"));
  bench.file.format = "sa-short";
  for (std::size_t k = 0; k < bench.file.rows.size(); ++k) {
    bench.file.rows[k].name = k < 3 ? fmt::format("B{}", k + 1) : fmt::format("P{}", k % 3 + 1);
  }
  bench.file.rows.erase(bench.file.rows.begin() + 7);
  CHECK_THROWS_WITH(bench.campaign(), Contains("bench.txt:9") && Contains("out of turn"));
}

TEST_CASE("nothing to zero to, two-way dates and an empty harvest are refused", "[points]") {
  Bench bench(6);
  bench.layout.frame = {.from = FrameFrom::zeroing};
  bench.layout.rows.base_every = 0;
  for (PlannedPoint& p : bench.plan.points) {
    p.target.x_mm += 5;  // none at home
    bench.add_pose(p.target);
  }
  CHECK_THROWS_WITH(bench.campaign(), Contains("nothing to zero to"));
  bench.file.rows[0].clock = parse_clock("02/12/25 10:00:00");
  bench.file.dates = date_reading({{1, *bench.file.rows[0].clock}}, {}, "bench.txt");
  CHECK_THROWS_WITH(bench.campaign(), Contains("two ways") && Contains("--date"));
  bench.file.rows[0].clock.reset();
  bench.layout.frame = {};
  for (PointRow& row : bench.file.rows) row.miss = Miss::zero;
  CHECK_THROWS_WITH(bench.campaign(), Contains("no pose is left"));
}

TEST_CASE("names are read by templates, and what fits none is refused by line", "[points]") {
  const NamePattern pattern("p{pose}-{nest}.{repeat}");
  const auto found = pattern.match("p017-P2.3");
  REQUIRE(found);
  CHECK(found->at("pose") == "17");
  CHECK(found->at("nest") == "P2");
  CHECK(found->at("repeat") == "3");
  CHECK_FALSE(pattern.match("p17-P2x3"));  // a dot is a dot
  CHECK_FALSE(pattern.match(std::string(500, 'p')));
  CHECK_FALSE(NamePattern("").match("x"));

  Bench bench(2);
  bench.layout.rows = {.by_name = true, .point = "{pose}{nest}"};
  bench.measure(kNothing);
  const std::vector<std::string> names = {"B1",  "B2",  "B3",  "1P1", "1P2",
                                          "1P3", "2P1", "2P2", "2P3"};
  for (std::size_t k = 0; k < names.size(); ++k) bench.file.rows[k].name = names[k];
  CHECK(bench.campaign().file.campaign.readings.size() == 2);
  bench.file.rows[8].name = "3P3";
  CHECK_THROWS_WITH(bench.campaign(), Contains("bench.txt:9") && Contains("no such pose"));
  bench.file.rows[8].name = "2P7";
  CHECK_THROWS_WITH(bench.campaign(), Contains("P7"));
  bench.file.rows[8].name = "hello";
  CHECK_THROWS_WITH(bench.campaign(), Contains("does not fit") && Contains("layout.json"));
}
