#include "core/calibrate/geometry_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/units.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;
using tests::kSigma;

namespace {

/// Readings of a robot with `truth`, on the paper's 80 points, at the given orientations.
std::vector<Reading> readings_at(const RobotModel& truth, std::vector<double> phis_deg,
                                 Random& random, double noise = 1) {
  std::vector<Reading> readings;
  const auto nominal = paper_mechanism().geometry;
  for (int k = -10; k <= 10; ++k) {
    if (k == 0) continue;
    for (const auto& [x, y] :
         {std::pair{10.0 * k, 0.0}, {0.0, 10.0 * k}, {10.0 * k, 10.0 * k}, {10.0 * k, -10.0 * k}}) {
      Reading r;
      r.seq = static_cast<int>(readings.size()) + 1;
      r.target = {x, y, rad_from_deg(phis_deg[readings.size() % phis_deg.size()])};
      r.conditions.cmd_mm = inverse(nominal, r.target).l_mm;
      r.conditions.epoch = truth.epochs.count(2) > 0 && r.seq > 40 ? 2 : 1;
      const Pose at = predict(truth, r.conditions).pose;
      r.measured = Pose{at.x_mm + noise * kSigma.xy_mm * random.normal(),
                        at.y_mm + noise * kSigma.xy_mm * random.normal(),
                        at.phi_rad + noise * kSigma.phi_rad * random.normal()};
      readings.push_back(r);
    }
  }
  return readings;
}

}  // namespace

TEST_CASE("the complete base has rank 18 once orientation varies and 12 when it does not",
          "[calibrate]") {
  Random random(21);
  RobotModel truth = nominal_model(paper_mechanism());
  set_geometry(truth.machine, tests::random_geometry(random));
  const auto turned = fit_geometry(nominal_model(paper_mechanism()),
                                   readings_at(truth, {-4, 0, 4}, random), kSigma);
  CHECK(turned.identified.rank == 18);
  const auto level =
      fit_geometry(nominal_model(paper_mechanism()), readings_at(truth, {0}, random), kSigma);
  CHECK(level.identified.rank == 12);
}

TEST_CASE("poses nobody measured are predicted within their stated uncertainty", "[calibrate]") {
  Random random(22);
  double sum = 0;
  int count = 0;
  for (int trial = 0; trial < 20; ++trial) {
    RobotModel truth = nominal_model(paper_mechanism());
    set_geometry(truth.machine, tests::random_geometry(random, 2));
    truth.epochs[2] = {{0.05, -0.1, 0.02}, {0.1, -0.05, rad_from_deg(0.02)}};
    const auto fit = fit_geometry(nominal_model(paper_mechanism()),
                                  readings_at(truth, {-4, 0, 4}, random), kSigma);
    REQUIRE(fit.status == GeometryFit::Status::converged);
    CHECK(fit.identified.rank == 24);
    for (int i = 0; i < 25; ++i) {
      Conditions c;
      c.cmd_mm =
          inverse(paper_mechanism().geometry, {random.uniform(-80, 80), random.uniform(-80, 80),
                                               rad_from_deg(random.uniform(-4, 4))})
              .l_mm;
      c.epoch = i % 2 + 1;
      const PredictedPose p = predict_with_covariance(fit, c);
      const Eigen::Vector3d off = p.pose.vector() - predict(truth, c).pose.vector();
      const double d2 = off.dot(p.covariance.ldlt().solve(off));
      CHECK(d2 < 28);  // chi^2(3): 500 clean draws exceed it in 0.2 % of runs
      sum += d2;
      ++count;
    }
  }
  // mean of chi^2(3) over 500 predictions, 50 a fit: correlated within a fit, so 20 independent
  // draws at least
  CHECK_THAT(sum / count, WithinAbs(3.0, 4 * std::sqrt(6.0 / 20)));
}

TEST_CASE("a robot measured without noise is reproduced to a nanometre", "[calibrate]") {
  Random random(23);
  RobotModel truth = nominal_model(paper_mechanism());
  set_geometry(truth.machine, tests::random_geometry(random, 5));
  const auto readings = readings_at(truth, {-4, 0, 4}, random, 0);
  const auto fit = fit_geometry(nominal_model(paper_mechanism()), readings, kSigma);
  CHECK(fit.status == GeometryFit::Status::converged);
  // directions below kLeastSignal stay nominal: they move no reading by a nanometre times their
  // count
  CHECK(fit.system.residual.cwiseAbs().maxCoeff() * kSigma.xy_mm < 1e-6);
}

TEST_CASE("a fit run twice gives the same bits", "[calibrate]") {
  Random random(24);
  RobotModel truth = nominal_model(paper_mechanism());
  set_geometry(truth.machine, tests::random_geometry(random));
  const auto readings = readings_at(truth, {-4, 0, 4}, random);
  const auto once = fit_geometry(nominal_model(paper_mechanism()), readings, kSigma);
  const auto twice = fit_geometry(nominal_model(paper_mechanism()), readings, kSigma);
  CHECK(once.z == twice.z);
  CHECK(once.covariance == twice.covariance);
}

TEST_CASE("Huber's fit is moved by a wrong reading far less than least squares", "[calibrate]") {
  Random random(25);
  RobotModel truth = nominal_model(paper_mechanism());
  auto readings = readings_at(truth, {-4, 0, 4}, random);
  readings[7].measured->x_mm += 1.0;
  const auto plain = fit_geometry(nominal_model(paper_mechanism()), readings, kSigma);
  const auto robust =
      fit_geometry(nominal_model(paper_mechanism()), readings, kSigma, {.huber = true});
  const auto off = [&](const GeometryFit& fit) {
    return (predict(fit.model, readings[7].conditions).pose.vector() - readings[7].target.vector())
        .head<2>()
        .norm();
  };
  CHECK(off(robust) < 0.5 * off(plain));
  CHECK(robust.weights[7] < 0.1);
}

TEST_CASE("a robot up to 3 mm and 1 deg from nominal in every parameter is found", "[calibrate]") {
  Random random(27);
  int damped = 0;
  for (int trial = 0; trial < 40; ++trial) {
    RobotModel truth = nominal_model(paper_mechanism());
    GeometryVector g = to_vector(truth.geometry());
    for (int k = 0; k < kGeometryParameters; ++k) {
      const bool angle = geometry_parameters()[static_cast<std::size_t>(k)].is_angle;
      g[k] += angle ? rad_from_deg(random.uniform(-1, 1)) : random.uniform(-3, 3);
    }
    set_geometry(truth.machine, from_vector(g));
    const auto readings = readings_at(truth, {-4, 0, 4}, random);
    const auto fit = fit_geometry(nominal_model(paper_mechanism()), readings, kSigma);
    INFO("trial " << trial << ", " << fit.iterations << " steps");
    CHECK(fit.status == GeometryFit::Status::converged);
    CHECK(fit.chi2 / fit.dof < 1.4);  // chi^2(222): beyond 1.4 in 1e-4 of fits
    damped += fit.damped;
    for (int i = 0; i < 5; ++i) {
      Conditions c;
      c.cmd_mm =
          inverse(paper_mechanism().geometry, {random.uniform(-80, 80), random.uniform(-80, 80),
                                               rad_from_deg(random.uniform(-4, 4))})
              .l_mm;
      const Eigen::Vector3d off =
          predict(fit.model, c).pose.vector() - predict(truth, c).pose.vector();
      CHECK(off.head<2>().norm() < 0.05);  // five times the noise
    }
  }
  INFO(damped << " damped steps");
}

TEST_CASE("where a whole Gauss-Newton step makes things worse, a damped one does not",
          "[calibrate]") {
  // 40 mm and 8 deg from nominal: far outside the linear range
  Random random(28);
  int damped = 0, converged = 0;
  for (int trial = 0; trial < 30; ++trial) {
    RobotModel start = nominal_model(paper_mechanism());
    GeometryVector g = to_vector(start.geometry());
    for (int k = 0; k < kGeometryParameters; ++k) {
      const bool angle = geometry_parameters()[static_cast<std::size_t>(k)].is_angle;
      g[k] += angle ? rad_from_deg(random.uniform(-8, 8)) : random.uniform(-40, 40);
    }
    set_geometry(start.machine, from_vector(g));
    const auto readings = readings_at(nominal_model(paper_mechanism()), {-4, 0, 4}, random);
    if (!std::ranges::all_of(readings,
                             [&](const Reading& r) { return predict(start, r.conditions).ok(); })) {
      continue;
    }
    const double before =
        whitened_system(start, readings, kSigma, base_parameters(start.nominal, readings))
            .residual.squaredNorm();
    const auto fit = fit_geometry(start, readings, kSigma, {.max_iterations = 200});
    CHECK(fit.chi2 <= before);
    damped += fit.damped;
    converged += fit.status == GeometryFit::Status::converged && fit.chi2 / fit.dof < 1.4 ? 1 : 0;
  }
  INFO(damped << " damped steps, " << converged << " converged");
  CHECK(damped > 0);
  CHECK(converged >= 10);
}

TEST_CASE("a fit converges also where drives stretch in a way the geometry cannot explain",
          "[calibrate]") {
  Random random(32);
  int quick = 0;
  for (int trial = 0; trial < 60; ++trial) {
    CAPTURE(trial);
    RobotModel truth = nominal_model(paper_mechanism());
    if (trial % 2 == 0) set_geometry(truth.machine, tests::random_geometry(random));
    const auto k = [&random] { return random.uniform(-0.006, 0.006); };
    truth.effects.push_back({&find_effect("lead_scale"), Eigen::Vector3d(k(), k(), k())});
    const auto fit =
        fit_geometry(nominal_model(paper_mechanism()), readings_at(truth, {0}, random), kSigma);
    CHECK(fit.chi2 / fit.dof > 2);  // the structure that is left
    quick += fit.status == GeometryFit::Status::converged && fit.iterations < 25 ? 1 : 0;
  }
  CHECK(quick >= 59);  // one begins 1258 tolerances from where it goes, down a narrow valley
}

TEST_CASE("readings of a clean campaign are called outliers in 1 of 100 campaigns at most",
          "[calibrate]") {
  Random random(29);
  int alarms = 0;
  for (int trial = 0; trial < 300; ++trial) {
    RobotModel truth = nominal_model(paper_mechanism());
    set_geometry(truth.machine, tests::random_geometry(random));
    const auto readings = readings_at(truth, {-4, 0, 4}, random);
    const auto fit = fit_geometry(nominal_model(paper_mechanism()), readings, kSigma);
    alarms += outlying_readings(fit, readings).empty() ? 0 : 1;
  }
  INFO(alarms);
  CHECK(alarms <= 10);  // binomial(300, 0.01): more than 10 in 0.02 % of runs
}

TEST_CASE("wrong readings are named by their seq, robust or not, and no right one with them",
          "[calibrate]") {
  Random random(30);
  RobotModel truth = nominal_model(paper_mechanism());
  auto readings = readings_at(truth, {-4, 0, 4}, random);
  readings[7].measured->x_mm += 0.3;
  readings[40].measured->y_mm -= 0.3;
  readings[66].measured->phi_rad += rad_from_deg(0.1);
  for (const bool huber : {false, true}) {
    const auto fit =
        fit_geometry(nominal_model(paper_mechanism()), readings, kSigma, {.huber = huber});
    std::vector<int> named;
    for (const OutlyingReading& o : outlying_readings(fit, readings)) {
      named.push_back(o.seq);
      CHECK((o.weight < 0.3) == huber);
    }
    CHECK(named == std::vector<int>{8, 41, 67});
  }
}

TEST_CASE(
    "Huber counts in the residuals' own spread: a model that lacks something keeps its weights",
    "[calibrate]") {
  Random random(31);
  auto readings = readings_at(nominal_model(paper_mechanism()), {-4, 0, 4}, random, 8);
  const auto fit =
      fit_geometry(nominal_model(paper_mechanism()), readings, kSigma, {.huber = true});
  CHECK(fit.scale > 6);
  CHECK((fit.weights.array() == 1).count() > 70);  // of 80; 3 % of clean readings lie beyond
  CHECK(outlying_readings(fit, readings).empty());
}

TEST_CASE("wrong readings are named, and no good neighbour, whatever the model lacks",
          "[calibrate]") {
  Random random(33);
  int n_wrong = 0, n_named = 0, n_false = 0;
  for (int trial = 0; trial < 32; ++trial) {
    RobotModel truth = nominal_model(paper_mechanism());
    set_geometry(truth.machine, tests::random_geometry(random));
    if (trial % 2 == 1) {
      truth.effects.push_back({&find_effect("lead_scale"), Eigen::Vector3d(0.004, 0.0025, 0.005)});
      truth.effects.push_back({&find_effect("backlash"), Eigen::Vector3d(0.08, 0.07, 0.09)});
    }
    auto readings = readings_at(truth, {0}, random);
    std::vector<int> wrong;
    for (int k = 0; k < trial % 4; ++k) {
      const std::size_t at = random.below(2) == 0 ? 72 + random.below(8) : random.below(80);
      Reading& r = readings[at];
      if (std::ranges::find(wrong, r.seq) != wrong.end()) continue;
      if (trial % 3 == 0) r.measured = Pose{};  // the tracker saw nothing
      const double off_mm = trial % 3 == 1 ? 90 : 3, turn_rad = random.uniform(0, 2 * kPi);
      if (trial % 3 != 0) r.measured->x_mm += off_mm * std::cos(turn_rad);
      if (trial % 3 != 0) r.measured->y_mm += off_mm * std::sin(turn_rad);
      wrong.push_back(r.seq);
    }
    const auto fit =
        fit_geometry(nominal_model(paper_mechanism()), readings, kSigma, {.huber = true});
    for (const OutlyingReading& o : outlying_readings(fit, readings)) {
      const bool right = std::ranges::find(wrong, o.seq) != wrong.end();
      (right ? n_named : n_false) += 1;
    }
    n_wrong += static_cast<int>(wrong.size());
  }
  CHECK(n_named == n_wrong);
  CHECK(n_false <= 2);  // 1 campaign in 100 names one by chance: more than 2 of 32 in 0.4 % of runs
}

TEST_CASE("unusable input of a fit is refused in words", "[calibrate]") {
  Random random(26);
  const auto readings = readings_at(nominal_model(paper_mechanism()), {0}, random);
  CHECK_THROWS_AS(fit_geometry(nominal_model(paper_mechanism()), {}, kSigma), InputError);
  CHECK_THROWS_WITH(fit_geometry(nominal_model(paper_mechanism()), readings, TrackerSigma{0, 1}),
                    Contains("sigma"));
}
