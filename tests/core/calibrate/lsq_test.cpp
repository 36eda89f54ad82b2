#include "core/calibrate/lsq.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>

#include "core/calibrate/lsq_system.hpp"
#include "core/error.hpp"
#include "core/judge/deviation.hpp"
#include "core/linear/least_squares.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/plan/grids.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

bool any_contains(const std::vector<std::string>& words, const std::string& part) {
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& w) { return w.find(part) != std::string::npos; });
}

const LsqParameter& named(const LsqResult& result, const std::string& name) {
  const auto at = std::find_if(result.parameters.begin(), result.parameters.end(),
                               [&](const LsqParameter& p) { return p.parameter.name == name; });
  REQUIRE(at != result.parameters.end());
  return *at;
}

std::vector<ScaledParameter> parameters_of(const LsqResult& result) {
  std::vector<ScaledParameter> all;
  for (const LsqParameter& p : result.parameters) all.push_back(p.parameter);
  return all;
}

std::vector<IdentifiedCombination> base_of(const LsqResult& result) {
  return identified_combinations(result.identifiability, parameters_of(result), result.covariance,
                                 result.values());
}

std::vector<std::string> words_of(const LsqResult& result) {
  const auto base = base_of(result);
  return in_words(result.identifiability, parameters_of(result), base,
                  strong_correlations(base, result.covariance));
}

/// Mean position error of the identified robot where it was never measured.
double unseen_mean_mm(const LsqResult& result, const Geometry& truth) {
  Random random(99);
  double mean = 0;
  constexpr int kPoses = 200;
  for (int k = 0; k < kPoses; ++k) {
    const auto l = inverse(paper_mechanism().geometry, random_pose(random)).l_mm;
    mean += position_error_mm(forward(result.geometry, l).pose, forward(truth, l).pose) / kPoses;
  }
  return mean;
}

}  // namespace

TEST_CASE("ranks and weighted sums of squares are those of an independent program", "[calibrate]") {
  const Table golden = read_table("core/calibrate/golden/linear_identification.csv");
  for (std::size_t k = 0; k < golden.rows.size(); ++k) {
    INFO(golden.text(k, "case"));
    const auto readings = of_set(golden_readings(golden.text(k, "case")), ReadingSet::identify);
    const LsqResult paper =
        identify_linear(paper_mechanism(), readings, kSigma, {.shared_epochs = true});
    CHECK(paper.n_equations == static_cast<int>(golden.number(k, "equations")));
    CHECK(paper.rank == static_cast<int>(golden.number(k, "rank_18")));
    CHECK_THAT(paper.weighted_rss, WithinRel(golden.number(k, "weighted_rss_18"), 1e-6));
    const LsqResult base = identify_linear(paper_mechanism(), readings, kSigma, {.complete = true});
    CHECK(base.rank == static_cast<int>(golden.number(k, "rank_base")));
    CHECK_THAT(base.weighted_rss, WithinRel(golden.number(k, "weighted_rss_base"), 1e-6));
  }
}

TEST_CASE("the paper's grid has rank 12 of 18, 15 with orientation, and 18 of the complete 21",
          "[calibrate]") {
  Random random(31);
  const Geometry truth = random_geometry(random);
  const auto flat = measure(truth, eighty_points(), random);
  auto targets = eighty_points();
  for (Pose& p : targets) p.phi_rad = rad_from_deg(random.uniform(-5, 5));
  const auto turned = measure(truth, targets, random);

  const LsqResult constant = identify_linear(paper_mechanism(), flat, kSigma);
  CHECK(constant.rank == 12);
  CHECK(any_contains(words_of(constant), "rank 12 of 18"));
  CHECK(any_contains(words_of(constant), "l_1 and R_1 act as one"));
  const LsqResult varied = identify_linear(paper_mechanism(), turned, kSigma);
  CHECK(varied.rank == 15);
  CHECK(any_contains(words_of(varied), "rank 15 of 18"));
  const LsqResult complete = identify_linear(paper_mechanism(), turned, kSigma, {.complete = true});
  CHECK(complete.rank == 18);
  CHECK(any_contains(words_of(complete), "rank 18 of 21"));
  CHECK(identify_linear(paper_mechanism(), flat, kSigma, {.complete = true}).rank == 12);
}

TEST_CASE("orientations that only the noise varies do not count as orientations", "[calibrate]") {
  Random random(32);
  auto targets = eighty_points();
  for (Pose& p : targets) p.phi_rad = rad_from_deg(0.08) * random.normal();
  const auto readings = measure(paper_mechanism().geometry, targets, random);
  const LsqResult result = identify_linear(paper_mechanism(), readings, kSigma);
  CHECK(result.identifiability.rank_machine == 15);
  CHECK(result.rank == 12);
  CHECK(any_contains(words_of(result), "carry nothing"));
}

TEST_CASE("l and R are never reported one by one, their difference is", "[calibrate]") {
  Random random(33);
  Geometry truth = paper_mechanism().geometry;
  truth.chains[1].l_zero_mm = 0.37;
  truth.chains[1].R_mm += 0.05;
  auto targets = random_poses(120, random);
  const LsqResult result =
      identify_linear(paper_mechanism(), measure(truth, targets, random), kSigma);
  CHECK_FALSE(named(result, "l_2").identified);
  CHECK_FALSE(named(result, "R_2").identified);
  CHECK(named(result, "S_2").identified);
  const auto base = base_of(result);
  CHECK(std::ranges::count_if(base, [](const auto& b) { return !b.alone; }) == 3);
  const auto c = std::ranges::find_if(base, [](const auto& b) { return b.name == "l_2 - R_2"; });
  REQUIRE(c != base.end());
  CHECK(c->standard_uncertainty > 0);
  CHECK(std::abs(*c->value - 0.32) < 5 * c->standard_uncertainty);
}

TEST_CASE("the identified robot predicts poses it never saw to a fraction of the noise",
          "[calibrate]") {
  Random random(34);
  for (int trial = 0; trial < 5; ++trial) {
    const Geometry truth = random_geometry(random, 0.3);  // small: first order must be enough
    const auto readings = measure(truth, random_poses(160, random), random);
    const LsqResult result =
        identify_linear(paper_mechanism(), readings, kSigma, {.complete = true});
    CHECK(unseen_mean_mm(result, truth) < kSigma.xy_mm);
    CHECK(result.sigma_ratio < 1.2);
    CHECK(result.sigma_ratio > 0.8);
  }
}

TEST_CASE("the basic solution fits as well with as many zeros as rank is missing", "[calibrate]") {
  const auto readings = of_set(golden_readings("d027"), ReadingSet::identify);
  const LsqResult least = identify_linear(paper_mechanism(), readings, kSigma);
  const LsqResult basic =
      identify_linear(paper_mechanism(), readings, kSigma, {.basic_solution = true});
  CHECK_THAT(basic.weighted_rss, WithinRel(least.weighted_rss, 1e-9));
  const auto zeros = std::count_if(basic.parameters.begin(), basic.parameters.end(),
                                   [](const LsqParameter& p) { return p.value == 0; });
  CHECK(zeros == 18 - 12);
}

TEST_CASE("a robot without any error is found as it is, whatever the solution", "[calibrate]") {
  Random random(8);
  const Geometry& nominal = paper_mechanism().geometry;
  auto readings = measure(nominal, eighty_points(), random);
  for (Reading& r : readings) {
    r.measured = forward(nominal, r.conditions.cmd_mm, r.target).pose;  // to the last bit
  }
  for (const bool basic : {false, true}) {
    const LsqResult result =
        identify_repeated(paper_mechanism(), readings, kSigma, {.basic_solution = basic}, 10);
    CHECK(result.values().isZero(0));
    CHECK(result.rank == 12);
  }
}

TEST_CASE("repeated identification drops the small sources, fits again and says which",
          "[calibrate]") {
  Random random(35);
  Geometry truth = paper_mechanism().geometry;
  truth.chains[0].l_zero_mm = -0.26;
  truth.chains[1].l_zero_mm = 0.37;
  truth.chains[2].l_zero_mm = -0.29;
  const auto readings = measure(truth, random_poses(100, random), random);
  const LsqResult result = identify_linear(paper_mechanism(), readings, kSigma,
                                           {.basic_solution = true, .drop_below = 0.5});
  REQUIRE(result.rounds.size() >= 2);
  CHECK_FALSE(result.rounds[0].dropped.empty());
  CHECK(result.rounds.back().dropped.empty());
  CHECK(result.rounds.back().columns < 18);
  CHECK(result.rounds.back().weighted_rss >= result.rounds[0].weighted_rss);
  CHECK(unseen_mean_mm(result, truth) < 0.010);
  for (const LsqParameter& p : result.parameters) {
    if (p.dropped) CHECK(p.value == 0);
    if (p.dropped) CHECK_FALSE(p.identified);
  }
}

TEST_CASE("a later epoch's own zeros and frame are found, and shared they are not", "[calibrate]") {
  Random random(36);
  const Geometry truth = random_geometry(random, 0.3);
  Geometry homed_again = truth;
  homed_again.chains[2].l_zero_mm += 0.2;
  auto readings = measure(truth, random_poses(120, random), random);
  auto later = measure(homed_again, random_poses(120, random), random);
  for (Reading& r : later) {
    r.seq += 120;
    r.conditions.epoch = 2;
    r.measured->x_mm += 0.05;
  }
  readings.insert(readings.end(), later.begin(), later.end());
  const LsqResult own = identify_linear(paper_mechanism(), readings, kSigma, {.complete = true});
  CHECK(own.rank == 24);
  CHECK_THAT(own.epochs.at(2).l_zero_mm[2], WithinAbs(0.2, 0.02));
  CHECK_THAT(own.epochs.at(2).frame.x_mm, WithinAbs(0.05, 0.02));
  const LsqResult shared = identify_linear(paper_mechanism(), readings, kSigma,
                                           {.complete = true, .shared_epochs = true});
  CHECK(shared.epochs.empty());
  CHECK(shared.sigma_ratio > 3);
  CHECK(own.sigma_ratio < 1.2);
}

TEST_CASE("a reading under a compensation tells the robot's error, not what is left",
          "[calibrate]") {
  Random random(37);
  const Geometry truth = random_geometry(random, 0.3);
  const auto plain = measure(truth, eighty_points(), random, {1e-9, 1e-9});
  auto compensated = plain;  // the same robot, sent by another command to the same targets
  for (Reading& r : compensated) {
    r.conditions.cmd_mm += Displacements(0.2, -0.1, 0.15);
    r.measured = forward(truth, r.conditions.cmd_mm).pose;
  }
  const LsqResult a = identify_linear(paper_mechanism(), plain, kSigma);
  const LsqResult b = identify_linear(paper_mechanism(), compensated, kSigma);
  for (std::size_t k = 0; k < a.parameters.size(); ++k) {
    const double tolerance = a.parameters[k].parameter.tolerance;
    CHECK(std::abs(a.parameters[k].value - b.parameters[k].value) < 0.05 * tolerance);
  }
}

TEST_CASE("one place, one reading, no reading and sigma zero are answered in words",
          "[calibrate]") {
  Random random(38);
  const Geometry truth = random_geometry(random, 0.3);
  const auto one_place = measure(truth, std::vector<Pose>(30, Pose{20, 30, 0}), random);
  const LsqResult result = identify_linear(paper_mechanism(), one_place, kSigma);
  CHECK(result.rank == 3);
  CHECK(any_contains(words_of(result), "rank 3 of 18"));
  CHECK(std::none_of(result.parameters.begin(), result.parameters.end(),
                     [](const LsqParameter& p) { return p.identified; }));

  CHECK(identify_linear(paper_mechanism(), std::span(one_place).first(1), kSigma).rank == 3);
  CHECK_THROWS_WITH(identify_linear(paper_mechanism(), {}, kSigma), Contains("not enough"));
  CHECK_THROWS_WITH(identify_linear(paper_mechanism(), one_place, {0, 1e-4}), Contains("positive"));
  auto missing = one_place;
  missing[3].measured.reset();
  CHECK_THROWS_WITH(identify_linear(paper_mechanism(), missing, kSigma), Contains("seq 4"));
}

TEST_CASE("a basic solution solves the chosen columns and leaves the others at zero",
          "[calibrate]") {
  Random random(31);
  Eigen::MatrixXd A(30, 5);
  for (double& value : A.reshaped()) value = random.normal();
  A.col(4) = A.col(0) - 2 * A.col(2);
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(5, 1, 5);
  const Eigen::VectorXd z = basic_solution(A, A * x, 4);
  CHECK((A * z - A * x).norm() < 1e-12);
  CHECK((z.array() == 0).count() == 1);
}

TEST_CASE("a basic solution is Eigen's, for any number of rows, with the same bits on each level",
          "[calibrate]") {
  Random random(32);
  for (const int rows : {5, 6, 8, 17, 240}) {
    Eigen::MatrixXd A(rows, 5);
    Eigen::VectorXd b(rows);
    for (double& value : A.reshaped()) value = random.normal();
    for (double& value : b) value = random.normal();
    const Eigen::VectorXd z = basic_solution(A, b, 5);
    CHECK((z - A.colPivHouseholderQr().solve(b)).norm() < 1e-10);
    for (const CpuLevel level : levels_here()) CHECK(basic_solution(A, b, 5, level) == z);
  }
  CHECK(basic_solution(Eigen::MatrixXd::Zero(9, 3), Eigen::VectorXd::Ones(9), 2).norm() == 0);
}

TEST_CASE(
    "the normal equations are Eigen's products, for any number of rows, with the same bits on "
    "each level",
    "[calibrate]") {
  Random random(33);
  for (const int rows : {1, 7, 8, 17, 240}) {
    Eigen::MatrixXd A(rows, 5);
    Eigen::VectorXd b(rows);
    for (double& value : A.reshaped()) value = random.normal();
    for (double& value : b) value = random.normal();
    const NormalEquations normal = normal_equations(A, b);
    CHECK((normal.AtA - A.transpose() * A).norm() < 1e-12);
    CHECK((normal.Atb - A.transpose() * b).norm() < 1e-12);
    for (const CpuLevel level : levels_here()) {
      CHECK(normal_equations(A, b, level).AtA == normal.AtA);
      CHECK(normal_equations(A, b, level).Atb == normal.Atb);
    }
  }
}

TEST_CASE("repeated steps end at the least sum of squares, with drops and later epochs too",
          "[calibrate]") {
  Random random(39);
  const Geometry truth = random_geometry(random, 20);  // far from nominal: first order overshoots
  auto readings = measure(truth, random_poses(80, random), random);
  auto later = measure(truth, random_poses(80, random), random);
  for (Reading& r : later) {
    r.seq += 80;
    r.conditions.epoch = 2;
    r.measured->y_mm += 0.3;
  }
  readings.insert(readings.end(), later.begin(), later.end());
  const std::vector<LsqOptions> all = {{.complete = true},
                                       {.complete = true, .basic_solution = true},
                                       {.complete = true, .drop_below = 2}};
  for (const LsqOptions& options : all) {
    CAPTURE(options.basic_solution, options.drop_below);
    const LsqResult first = identify_linear(paper_mechanism(), readings, kSigma, options);
    const LsqResult last = identify_repeated(paper_mechanism(), readings, kSigma, options, 20);
    CHECK(last.steps > 2);
    CHECK(last.steps < 20);
    Mechanism at = paper_mechanism();
    at.geometry = last.geometry;
    const LsqSystem end = lsq_system(at, readings, kSigma, options, last.epochs);
    CHECK_THAT(end.b.squaredNorm(), WithinRel(last.weighted_rss, 1e-6));
    at.geometry = first.geometry;
    const LsqSystem begun = lsq_system(at, readings, kSigma, options, first.epochs);
    CHECK(end.b.squaredNorm() < 0.99 * begun.b.squaredNorm());
    // The gradient in the columns that are free; unidentified directions have none.
    for (std::size_t k = 0; k < last.parameters.size(); ++k) {
      const LsqParameter& p = last.parameters[k];
      if (p.dropped) CHECK(p.value == 0);
      if (p.dropped || (options.basic_solution && p.value == 0)) continue;
      const auto column = end.A.col(static_cast<Eigen::Index>(k));
      CHECK(std::abs(column.dot(end.b)) < 1e-4 * column.norm() * end.b.norm());
    }
  }
}

TEST_CASE("where constants cannot explain the readings, attitude is kept by its weight",
          "[calibrate]") {
  Random random(40);
  const Mechanism robot = paper_mechanism();
  const TrackerSigma coarse{0.010, rad_from_deg(0.055)};
  auto readings = measure(robot.geometry, paper_80(), random, coarse);
  const Displacements home = inverse(robot.geometry, robot.home).l_mm;
  for (Reading& r : readings) {  // a drive error that grows with travel
    const Displacements travel = r.conditions.cmd_mm - home;
    const Displacements l =
        r.conditions.cmd_mm + travel.cwiseProduct(Displacements(4e-3, 2e-3, 5e-3));
    const Pose moved = forward(robot.geometry, l).pose;
    const Pose still = forward(robot.geometry, r.conditions.cmd_mm).pose;
    r.measured = Pose::from(r.measured->vector() + moved.vector() - still.vector());
  }
  const LsqResult as_stated = identify_repeated(robot, readings, coarse, {}, 10);
  const LsqResult weighted =
      identify_repeated(robot, readings, coarse, {.attitude_weight = 10}, 10);
  CHECK(as_stated.position_rms_sigma > 3);
  CHECK(weighted.attitude_rms_sigma < 0.9 * as_stated.attitude_rms_sigma);
  CHECK(weighted.position_rms_sigma > as_stated.position_rms_sigma);
  CHECK_THROWS_WITH(identify_linear(robot, readings, coarse, {.attitude_weight = 0}),
                    Contains("attitude_weight"));
}
