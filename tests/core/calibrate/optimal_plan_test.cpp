#include "core/calibrate/optimal_plan.hpp"

#include <Eigen/Cholesky>
#include <cstdio>

#include "core/calibrate/geometry_fit.hpp"
#include "core/error.hpp"
#include "core/plan/named.hpp"
#include "core/units.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;
using tests::kSigma;

namespace {

const std::vector<double> kTurnedRad = {rad_from_deg(-5.0), 0, rad_from_deg(5.0)};
const std::vector<std::string> kEffects = {"lead_scale", "backlash"};

OptimalRequest request(int points, Criterion criterion = Criterion::D) {
  return {.points = points,
          .criterion = criterion,
          .effects = kEffects,
          .sigma = kSigma,
          .step_mm = 50,
          .orientations_rad = kTurnedRad};
}

double log_det(const Eigen::MatrixXd& J) {
  Eigen::MatrixXd M = J.transpose() * J;
  M.diagonal().array() += 1;
  return 2 * Eigen::LLT<Eigen::MatrixXd>(M).matrixLLT().diagonal().array().log().sum();
}

/// Mean position error over the workspace of fits to simulated readings of a plan, mm.
double mean_error_mm(const Plan& plan, int robots,
                     const std::vector<double>& workspace_rad = kTurnedRad) {
  const Mechanism mechanism = paper_mechanism();
  const DesignModel design = design_model(mechanism, kSigma, kEffects);
  RobotModel start = design.model;
  for (ActiveEffect& e : start.effects) e.values.setConstant(1e-12);  // to be fitted
  Random random(77);
  double sum = 0;
  int n = 0;
  for (int robot = 0; robot < robots; ++robot) {
    Eigen::VectorXd z(static_cast<Eigen::Index>(design.parameters.size()));
    for (double& value : z) value = random.normal();
    const RobotModel truth = moved(design.model, design.parameters, z);
    std::vector<Reading> readings;
    for (const Conditions& c : expected_conditions(plan, mechanism)) {
      const Pose at = predict(truth, c).pose;
      readings.push_back({.seq = static_cast<int>(readings.size()) + 1,
                          .target = at,
                          .conditions = c,
                          .measured = Pose{at.x_mm + kSigma.xy_mm * random.normal(),
                                           at.y_mm + kSigma.xy_mm * random.normal(),
                                           at.phi_rad + kSigma.phi_rad * random.normal()}});
    }
    const GeometryFit fit = fit_geometry(start, readings, kSigma, {.tolerance_prior = true});
    for (const Pose& pose : comparison_poses(workspace_rad)) {
      const Conditions c = conditions_at(mechanism, pose, {1, 1, 1}, 5);
      const Eigen::Vector3d off =
          predict(fit.model, c).pose.vector() - predict(truth, c).pose.vector();
      sum += off.head<2>().norm();
      ++n;
    }
  }
  return sum / n;
}

}  // namespace

TEST_CASE("no single exchange of a D-optimal plan's points for a candidate gains", "[calibrate]") {
  const Mechanism mechanism = paper_mechanism();
  const OptimalPlan optimal = optimal_plan(mechanism, request(12));
  CHECK(optimal.at_end > optimal.at_start);
  const DesignModel design = design_model(mechanism, kSigma, kEffects);
  const double best = log_det(optimal.jacobian);
  CHECK_THAT(best, WithinRel(optimal.at_end, 1e-9));
  Random random(5);
  for (int trial = 0; trial < 300; ++trial) {
    Eigen::MatrixXd J = optimal.jacobian;
    const Pose pose{50.0 * (static_cast<double>(random.below(5)) - 2),
                    50.0 * (static_cast<double>(random.below(5)) - 2), kTurnedRad[random.below(3)]};
    const auto sign = [&] { return random.below(2) == 0 ? -1 : 1; };
    const Conditions c = conditions_at(mechanism, pose, {sign(), sign(), sign()}, 5);
    const auto slot = static_cast<Eigen::Index>(random.below(12));
    J.middleRows<3>(3 * slot) = design_jacobian(design, std::vector{c});
    CHECK(log_det(J) <= best * (1 + 1e-9));
  }
}

TEST_CASE("each criterion is served best by its own plan", "[calibrate]") {
  const Mechanism mechanism = paper_mechanism();
  for (const Criterion criterion : {Criterion::D, Criterion::A, Criterion::E}) {
    const OptimalPlan plan = optimal_plan(mechanism, request(24, criterion));
    const bool less_is_better = criterion == Criterion::A;
    CHECK((less_is_better ? plan.at_end < plan.at_start : plan.at_end > plan.at_start));
  }
  const DesignModel design = design_model(mechanism, kSigma, kEffects);
  const auto weakest = [&](Criterion criterion) {
    const auto known =
        identifiability(design, optimal_plan(mechanism, request(24, criterion)).jacobian);
    return known.singular[23];
  };
  CHECK(weakest(Criterion::E) > weakest(Criterion::D));
}

TEST_CASE("the same seed chooses the same points, and all of them are safe", "[calibrate]") {
  const Mechanism mechanism = paper_mechanism();
  const Plan once = optimal_plan(mechanism, request(20)).plan;
  const Plan twice = optimal_plan(mechanism, request(20)).plan;
  REQUIRE(once.points.size() == 20);
  for (std::size_t k = 0; k < 20; ++k) {
    CHECK(once.points[k].target == twice.points[k].target);
    CHECK(once.points[k].approach == twice.points[k].approach);
  }
  CHECK(check(once, mechanism).empty());
}

TEST_CASE("sixteen optimal points predict the turned workspace better than paper-80",
          "[calibrate]") {
  const Mechanism mechanism = paper_mechanism();
  const DesignModel design = design_model(mechanism, kSigma, kEffects);
  const auto predicted = [&](const Plan& plan) {
    return predicted_uncertainty(design,
                                 design_jacobian(design, expected_conditions(plan, mechanism)),
                                 comparison_poses(kTurnedRad));
  };
  OptimalRequest asked = request(16);
  asked.step_mm = 20;
  const Plan optimal = optimal_plan(mechanism, asked).plan;
  const Plan paper = named_plan("paper-80");
  CHECK(predicted(optimal).mean_mm < predicted(paper).mean_mm);
  CHECK(predicted(optimal).max_mm < predicted(paper).max_mm);

  constexpr int kRobots = 20;
  const double optimal_mm = mean_error_mm(optimal, kRobots);
  CHECK(optimal_mm < mean_error_mm(paper, kRobots));
  // The mean of a planar normal's length is sqrt(pi / 4) of its root mean square. Twenty robots of
  // 24 parameters: a tenth is four standard deviations of the mean.
  CHECK_THAT(optimal_mm, WithinRel(std::sqrt(M_PI / 4) * predicted(optimal).mean_mm, 0.2));
}

TEST_CASE("how many optimal points are worth paper-80, in simulation", "[.][slow]") {
  // Mean position error, um, of fits (geometry, lead_scale,
  // backlash; tolerances as priors) to simulated readings, over +-100 mm, 40 drawn robots.
  constexpr int kRobots = 40;
  const Mechanism mechanism = paper_mechanism();
  const std::vector<double> level_rad = {0};
  double paper_um[2] = {}, at_16 = 0, at_40 = 0;
  for (const auto* workspace : {&kTurnedRad, &level_rad}) {
    const bool turned = workspace == &kTurnedRad;
    paper_um[turned ? 0 : 1] = 1000 * mean_error_mm(named_plan("paper-80"), kRobots, *workspace);
    std::printf("%s: paper-80 %.2f um;", turned ? "-5, 0, 5 deg" : "0 deg",
                paper_um[turned ? 0 : 1]);
    for (const int points : {8, 12, 16, 24, 32, 40, 80}) {
      OptimalRequest asked = request(points);
      asked.step_mm = 20;
      asked.orientations_rad = *workspace;
      const double um =
          1000 * mean_error_mm(optimal_plan(mechanism, asked).plan, kRobots, *workspace);
      std::printf(" %d: %.2f", points, um);
      if (turned && points == 16) at_16 = um;
      if (!turned && points == 40) at_40 = um;
    }
    std::printf("\n");
  }
  CHECK(at_16 < paper_um[0]);
  CHECK(at_40 < paper_um[1]);
}

TEST_CASE("a plan that cannot be chosen is refused in words", "[calibrate]") {
  const Mechanism mechanism = paper_mechanism();
  CHECK_THROWS_AS(optimal_plan(mechanism, request(1)), InputError);
  OptimalRequest far = request(10);
  far.half_width_mm = 5000;
  far.step_mm = 10000 - 1;  // the corners, and the centre
  far.orientations_rad = {3.0};
  CHECK_THROWS_WITH(optimal_plan(mechanism, far), Contains("safely"));
  OptimalRequest blunt = request(10);
  blunt.sigma = {0, 1};
  CHECK_THROWS_WITH(optimal_plan(mechanism, blunt), Contains("weighted"));
  OptimalRequest unknown = request(10);
  unknown.effects = {"gravity"};
  CHECK_THROWS_AS(optimal_plan(mechanism, unknown), NotFoundError);
}
