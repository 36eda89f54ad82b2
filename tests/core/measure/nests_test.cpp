#include "core/measure/nests.hpp"

#include <limits>

#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/nests.hpp"

using namespace trammel;

namespace {

constexpr double kSigmaMm = 0.005;

NestFrame frame_of(std::vector<NestPoint> body) {
  NestFrame frame;
  frame.body = std::move(body);
  return frame;
}

/// Standard deviations and covariances over draws, beside those that are stated.
struct Drawn {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d stated = Eigen::Matrix3d::Zero();
  int not_ok = 0;
};

Drawn draw(const NestFrame& frame, const Pose& pose, int n) {
  Random random(71);
  Drawn drawn;
  const auto clean = tests::seen_at(pose, frame);
  for (int k = 0; k < n; ++k) {
    auto points = clean;
    for (auto& p : points) p.at_mm += tests::noise_mm(random, kSigmaMm);
    const NestPose seen = pose_of_nests(points, frame, kSigmaMm);
    const Eigen::Vector3d d = seen.pose.vector() - pose.vector();
    drawn.covariance += d * d.transpose() / n;
    drawn.mean += d / n;
    drawn.stated = seen.covariance;
    drawn.not_ok += seen.ok() ? 0 : 1;
  }
  return drawn;
}

/// Entry by entry in units of the stated standard deviations: 10,000 draws know a variance to
/// 1.4 %, a correlation to 1 %.
void check_covariance(const NestFrame& frame, const Pose& pose) {
  const Drawn drawn = draw(frame, pose, 10000);
  const Eigen::Vector3d u = drawn.stated.diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < 3; ++i) {
    CHECK(std::abs(drawn.mean[i]) < 0.05 * u[i]);  // five standard errors
    for (Eigen::Index j = 0; j < 3; ++j) {
      INFO(i << " " << j);
      CHECK_THAT(drawn.covariance(i, j) / (u[i] * u[j]),
                 WithinAbs(drawn.stated(i, j) / (u[i] * u[j]), 0.07));
    }
  }
}

}  // namespace

TEST_CASE("nests measured where the body has them read pose zero", "[measure][nests]") {
  const NestFrame frame = frame_of(tests::triangle(150));
  const NestPose seen = pose_of_nests(frame.body, frame, kSigmaMm);
  CHECK(seen.ok());
  CHECK(seen.n_nests == 3);
  CHECK(seen.pose.vector().norm() < 1e-12);
  CHECK(seen.quality.rms_mm < 1e-12);
  CHECK(seen.quality.out_of_plane_mm == 0);
  CHECK_THAT(seen.quality.scale, WithinRel(1.0, 1e-12));
}

TEST_CASE("a pose comes back from tracker points in any frame", "[measure][nests]") {
  Random random(72);
  for (int trial = 0; trial < 100; ++trial) {
    NestFrame frame = frame_of(tests::triangle(150, {30, -20, 12}));
    frame.body[1].at_mm += Eigen::Vector3d(14, -3, 25);  // neither regular nor level
    frame.T_B_T = tests::random_frame(random);
    if (trial % 2 == 1) frame.body.pop_back();
    const Pose pose{random.uniform(-100, 100), random.uniform(-100, 100),
                    random.uniform(-kPi, kPi)};
    const NestPose seen = pose_of_nests(tests::seen_at(pose, frame, 55), frame, kSigmaMm);
    REQUIRE(seen.ok());
    CHECK((seen.pose.vector() - pose.vector()).norm() < 1e-9);
    CHECK_THAT(seen.quality.height_mm, WithinAbs(55, 1e-9));
    CHECK(seen.quality.out_of_plane_mm < 1e-9);
    CHECK(std::abs(seen.quality.side_mm) < 1e-9);
  }
}

TEST_CASE("an equilateral triangle of 150 mm under 5 um knows phi to 33 urad", "[measure][nests]") {
  const NestFrame frame = frame_of(tests::triangle(150));
  const NestPose seen = pose_of_nests(frame.body, frame, kSigmaMm);
  CHECK_THAT(std::sqrt(seen.covariance(2, 2)), WithinAbs(33e-6, 0.5e-6));
  CHECK_THAT(std::sqrt(seen.covariance(0, 0)), WithinRel(kSigmaMm / std::sqrt(3.0), 1e-12));
  CHECK(std::abs(seen.covariance(0, 2)) < 1e-15);
}

TEST_CASE("two nests at a distance d know phi to sigma sqrt(2) / d", "[measure][nests]") {
  NestFrame frame = frame_of({{"a", {0, 0, 0}}, {"b", {40, 30, 0}}});
  const NestPose seen = pose_of_nests(frame.body, frame, kSigmaMm);
  CHECK(seen.ok());
  CHECK_THAT(std::sqrt(seen.covariance(2, 2)), WithinRel(kSigmaMm * std::sqrt(2.0) / 50, 1e-12));
}

TEST_CASE("the stated covariance is that of 10,000 drawn measurements", "[measure][nests]") {
  const Pose pose{-40, 65, rad_from_deg(25)};
  check_covariance(frame_of(tests::triangle(150)), pose);
  check_covariance(frame_of(tests::triangle(80, {200, -60, 0})),
                   pose);  // origin far from the nests
  check_covariance(frame_of({{"a", {10, 0, 0}}, {"b", {90, 20, 0}}}), pose);
  NestFrame line = frame_of({{"a", {-60, 5, 0}}, {"b", {0, 5, 0}}, {"c", {90, 5, 0}}});
  check_covariance(line, pose);  // nests in one line show phi as well
}

TEST_CASE("a sound body is called not rigid in no more poses than the stated share",
          "[measure][nests]") {
  NestFrame frame = frame_of(tests::triangle(150));
  frame.false_alarm = 0.01;
  const Drawn drawn = draw(frame, {10, 20, 0.1}, 10000);
  // sides share nests: below the stated 100 of 10,000, and above a third of it
  CHECK(drawn.not_ok <= 125);  // binomial(10,000, 0.01): more in 1 % of runs
  CHECK(drawn.not_ok >= 33);
}

TEST_CASE("one nest shows where it is, and says that phi is not observed", "[measure][nests]") {
  const NestFrame frame = frame_of({{"centre", {0, 0, 0}}, {"arm", {86.6, 50, 0}}});
  const auto all = tests::seen_at({12, -7, 0.2}, frame);
  const NestPose centre = pose_of_nests({all[0]}, frame, kSigmaMm);
  CHECK(centre.status == NestStatus::phi_not_observed);
  CHECK(name_of(centre.status) == std::string("phi not observed"));
  CHECK_THAT(centre.pose.x_mm, WithinAbs(12, 1e-12));
  CHECK_THAT(centre.pose.y_mm, WithinAbs(-7, 1e-12));
  CHECK(centre.at_body_mm.norm() == 0);
  CHECK_THAT(centre.covariance(0, 0), WithinRel(kSigmaMm * kSigmaMm, 1e-12));
  const NestPose arm = pose_of_nests({all[1]}, frame, kSigmaMm);
  CHECK(arm.status == NestStatus::phi_not_observed);
  CHECK(arm.at_body_mm == Eigen::Vector2d(86.6, 50));  // x and y are of this point, not of O_C
  CHECK_THAT(arm.pose.x_mm, WithinAbs(all[1].at_mm.x(), 1e-12));
  CHECK(pose_of_nests({}, frame, kSigmaMm).status == NestStatus::no_nests);
}

TEST_CASE("nests stacked over one another show no phi", "[measure][nests]") {
  const NestFrame frame = frame_of({{"low", {30, 0, 0}}, {"high", {30, 0, 40}}});
  const NestPose seen = pose_of_nests(frame.body, frame, kSigmaMm);
  CHECK(seen.status == NestStatus::phi_not_observed);
  CHECK(seen.at_body_mm == Eigen::Vector2d(30, 0));
}

TEST_CASE("swapped names and a frame seen from below are mirrored, not a pose",
          "[measure][nests]") {
  NestFrame frame = frame_of(tests::triangle(150));
  auto points = tests::seen_at({10, 20, 0.1}, frame);
  std::swap(points[0].nest, points[2].nest);
  CHECK(pose_of_nests(points, frame, kSigmaMm).status == NestStatus::mirrored);
  std::swap(points[0].nest, points[2].nest);
  CHECK(pose_of_nests(points, frame, kSigmaMm).ok());
  frame.T_B_T.linear() = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  CHECK(pose_of_nests(points, frame, kSigmaMm).status == NestStatus::mirrored);
}

TEST_CASE("a side beyond chance is named; another unit shows as a scale", "[measure][nests]") {
  const NestFrame frame = frame_of(tests::triangle(150));
  auto points = tests::seen_at({10, 20, 0.1}, frame);
  points[1].at_mm.x() += 0.2;
  const NestPose off = pose_of_nests(points, frame, kSigmaMm);
  CHECK(off.status == NestStatus::not_rigid);
  CHECK(off.quality.side.find("P2") != std::string::npos);
  CHECK(std::abs(off.quality.side_mm) > 0.09);
  CHECK_THAT(off.quality.side_limit_mm, WithinRel(3.588 * kSigmaMm * std::sqrt(2.0), 1e-3));
  auto metres = frame.body;
  for (auto& p : metres) p.at_mm /= 1000;
  const NestPose small = pose_of_nests(metres, frame, kSigmaMm);
  CHECK(small.status == NestStatus::not_rigid);
  CHECK_THAT(small.quality.scale, WithinRel(0.001, 1e-9));
}

TEST_CASE("a platform that tilts shows out of plane, not as a pose error", "[measure][nests]") {
  const NestFrame frame = frame_of(tests::triangle(150));
  auto points = frame.body;
  points[0].at_mm.z() += 0.09;
  const NestPose seen = pose_of_nests(points, frame, kSigmaMm);
  CHECK(seen.ok());
  CHECK_THAT(seen.quality.height_mm, WithinAbs(0.03, 1e-12));
  CHECK_THAT(seen.quality.out_of_plane_mm, WithinAbs(0.06, 1e-12));
}

TEST_CASE("a nest that the body lacks, a nest twice and a NaN are refused by name",
          "[measure][nests]") {
  const NestFrame frame = frame_of(tests::triangle(150));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(pose_of_nests({{"P9", {0, 0, 0}}}, frame, kSigmaMm),
                    Contains("P9") && Contains("P1, P2, P3"));
  CHECK_THROWS_WITH(pose_of_nests({frame.body[0], frame.body[0]}, frame, kSigmaMm),
                    Contains("twice") && Contains("P1"));
  CHECK_THROWS_WITH(pose_of_nests({{"P2", {0, nan, 0}}}, frame, kSigmaMm), Contains("P2"));
  CHECK_THROWS_AS(pose_of_nests(frame.body, frame, 0), InputError);
  CHECK_THROWS_AS(pose_of_nests(frame.body, frame, nan), InputError);
}
