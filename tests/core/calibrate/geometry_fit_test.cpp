#include "core/calibrate/geometry_fit.hpp"

#include <Eigen/Cholesky>

#include "core/error.hpp"
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
  truth.geometry = tests::random_geometry(random);
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
    truth.geometry = tests::random_geometry(random, 2);
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
  truth.geometry = tests::random_geometry(random, 5);
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
  truth.geometry = tests::random_geometry(random);
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

TEST_CASE("unusable input of a fit is refused in words", "[calibrate]") {
  Random random(26);
  const auto readings = readings_at(nominal_model(paper_mechanism()), {0}, random);
  CHECK_THROWS_AS(fit_geometry(nominal_model(paper_mechanism()), {}, kSigma), InputError);
  CHECK_THROWS_WITH(fit_geometry(nominal_model(paper_mechanism()), readings, {0, 1}),
                    Contains("sigma"));
}
