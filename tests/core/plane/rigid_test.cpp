#include "core/plane/rigid.hpp"

#include <Eigen/Geometry>

#include "tests/support/catch.hpp"
#include "tests/support/nests.hpp"

using namespace trammel;

TEST_CASE("a plane through points of a plane is that plane, wherever it lies", "[measure]") {
  Random random(61);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Isometry3d T = tests::random_frame(random);
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < 12; ++k) {
      points.emplace_back(T *
                          Eigen::Vector3d(random.uniform(-200, 200), random.uniform(-90, 90), 0));
    }
    const Plane plane = fit_plane(points);
    REQUIRE(plane.observed);
    CHECK_THAT(std::abs(plane.normal.dot(T.linear().col(2))), WithinAbs(1, 1e-12));
    CHECK(plane.normal.maxCoeff() == plane.normal.cwiseAbs().maxCoeff());
    CHECK(plane.max_mm < 1e-9);
    CHECK(plane.rms_mm < 1e-9);
  }
}

TEST_CASE("a plane's residual and tilt are those of the noise that was put in", "[measure]") {
  constexpr double kSigma = 0.01;
  constexpr int kTrials = 2000;
  Random random(62);
  double residual = 0, tilt = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < 10; ++k) points.emplace_back(20.0 * k, k % 2 == 0 ? 50 : -50, 0);
    for (auto& p : points) p += tests::noise_mm(random, kSigma);
    const Plane plane = fit_plane(points);
    residual += plane.rms_mm * plane.rms_mm / kTrials;
    tilt += std::pow(plane.normal.y() * plane.width_mm, 2) / kTrials;
  }
  // relative standard errors of the two: sqrt(2 / (7 * 2000)) and sqrt(2 / 2000), five of each
  CHECK_THAT(std::sqrt(residual), WithinRel(kSigma, 0.03));
  CHECK_THAT(std::sqrt(tilt), WithinRel(kSigma, 0.08));
}

TEST_CASE("two points, or points along a line, show no plane", "[measure]") {
  std::vector<Eigen::Vector3d> points = {{0, 0, 0}, {100, 20, 5}};
  CHECK_FALSE(fit_plane({}).observed);
  CHECK_FALSE(fit_plane(points).observed);
  points.emplace_back(200, 40, 10.05);
  CHECK_FALSE(fit_plane(points).observed);
  points.back().y() += 3;
  CHECK(fit_plane(points).observed);
}

TEST_CASE("a planar fit finds the move that was made, and never turns the body over", "[measure]") {
  Random random(63);
  const std::vector<Eigen::Vector2d> body = {{0, 90}, {-80, -40}, {75, -50}};
  for (int trial = 0; trial < 100; ++trial) {
    const double turn = random.uniform(-kPi, kPi);
    const Eigen::Vector2d shift(random.uniform(-500, 500), random.uniform(-500, 500));
    std::vector<Eigen::Vector2d> seen, over;
    for (const auto& b : body) {
      seen.emplace_back(shift + Eigen::Rotation2Dd(turn) * b);
      over.emplace_back(-seen.back().x(), seen.back().y());
    }
    const PlanarFit fit = fit_planar(body, seen);
    CHECK_THAT(std::remainder(fit.turn_rad - turn, 2 * kPi), WithinAbs(0, 1e-12));
    CHECK((fit.shift_mm - shift).norm() < 1e-9);
    CHECK(fit.rms_mm < 1e-9);
    CHECK(fit.mirrored_rms_mm > 10);
    CHECK_THAT(fit.scale, WithinRel(1.0, 1e-12));
    const PlanarFit mirrored = fit_planar(body, over);
    CHECK(mirrored.rms_mm > 10);
    CHECK(mirrored.mirrored_rms_mm < 1e-9);
  }
}

TEST_CASE("one point turns nothing; points along a line do", "[measure]") {
  const std::vector<Eigen::Vector2d> one = {{3, 4}}, there = {{10, 10}};
  const PlanarFit alone = fit_planar(one, there);
  CHECK(alone.turn_rad == 0);
  CHECK(alone.spread_mm2 == 0);
  CHECK(alone.shift_mm == Eigen::Vector2d(7, 6));
  const std::vector<Eigen::Vector2d> line = {{0, 0}, {50, 0}, {120, 0}};
  const std::vector<Eigen::Vector2d> up = {{1, 2}, {1, 52}, {1, 122}};
  const PlanarFit fit = fit_planar(line, up);
  CHECK_THAT(fit.turn_rad, WithinAbs(kPi / 2, 1e-14));
  CHECK(fit.rms_mm < 1e-12);
}
