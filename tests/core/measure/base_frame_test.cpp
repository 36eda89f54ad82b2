#include "core/measure/base_frame.hpp"

#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/nests.hpp"

using namespace trammel;

namespace {

const std::vector<NestPoint> kBase = {{"B1", {-500, -400, 20}},
                                      {"B2", {500, -400, 25}},
                                      {"B3", {0, 600, 15}},
                                      {"B4", {300, 300, 80}}};

std::vector<NestPoint> from(const Eigen::Isometry3d& T, std::vector<NestPoint> points) {
  for (auto& p : points) p.at_mm = T * p.at_mm;
  return points;
}

}  // namespace

TEST_CASE("base nests register the tracker wherever it stands", "[measure][nests]") {
  Random random(81);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Isometry3d T_T_B = tests::random_frame(random);
    auto measured = from(T_T_B, kBase);
    measured.push_back({"elsewhere", {1, 2, 3}});  // not of the base: passed over
    if (trial % 2 == 1) measured.erase(measured.begin());
    const BaseFrame frame = frame_of_base(measured, kBase);
    CHECK(frame.n_nests == (trial % 2 == 1 ? 3 : 4));
    CHECK((frame.T_B_T * T_T_B).isApprox(Eigen::Isometry3d::Identity(), 1e-9));
    CHECK(frame.max_mm < 1e-8);
  }
}

TEST_CASE("the residual of a registration is the noise that was put in", "[measure][nests]") {
  constexpr double kSigma = 0.008;
  constexpr int kTrials = 1000;
  Random random(82);
  double square = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    auto measured = from(tests::random_frame(random), kBase);
    for (auto& p : measured) p.at_mm += tests::noise_mm(random, kSigma);
    const double rms = frame_of_base(measured, kBase).rms_mm;
    square += rms * rms / kTrials;
  }
  CHECK_THAT(std::sqrt(square), WithinRel(kSigma, 0.05));  // 6000 degrees: five standard errors
  auto measured = kBase;
  measured[2].at_mm.y() += 0.5;
  CHECK(frame_of_base(measured, kBase).worst == "B3");
}

TEST_CASE("base nests in one line, two of them, or one twice register nothing",
          "[measure][nests]") {
  auto line = kBase;
  for (auto& p : line) p.at_mm.y() = p.at_mm.z() = 0;
  CHECK_THROWS_WITH(frame_of_base(line, line), Contains("near one line"));
  CHECK_THROWS_WITH(frame_of_base({kBase[0], kBase[1]}, kBase), Contains("2 nests measured"));
  CHECK_THROWS_WITH(frame_of_base({kBase[0], kBase[0]}, kBase), Contains("duplicate base nest"));
}

TEST_CASE("zeroing on the plane of motion makes home read home and the rest move along",
          "[measure][nests]") {
  Random random(83);
  for (int trial = 0; trial < 30; ++trial) {
    NestFrame truth;
    truth.body = tests::triangle(150, {12, -9, 0});
    truth.body[0].at_mm.z() = 30;  // nests at different heights
    truth.T_B_T = tests::random_frame(random);
    const Pose home{0, 0, 0};
    std::vector<Pose> poses = {home};
    std::vector<NestPoint> all = tests::seen_at(home, truth, 44);
    for (int k = 0; k < 20; ++k) {
      poses.push_back(
          {random.uniform(-100, 100), random.uniform(-100, 100), 0.1 * random.normal()});
      for (auto& p : tests::seen_at(poses.back(), truth, 44)) all.push_back(p);
    }
    const Plane plane = motion_plane(all);
    REQUIRE(plane.observed);
    CHECK(plane.max_mm < 1e-8);
    NestFrame frame = truth;
    frame.T_B_T = frame_on_plane(plane, truth.T_B_T.linear().row(2).transpose());
    const NestPose at_home = pose_of_nests(tests::seen_at(home, truth, 44), frame, 0.005);
    frame.T_B_T = zeroed(frame.T_B_T, at_home, home);
    for (const Pose& pose : poses) {
      const NestPose seen = pose_of_nests(tests::seen_at(pose, truth, 44), frame, 0.005);
      REQUIRE(seen.ok());
      CHECK((seen.pose.vector() - pose.vector()).norm() < 1e-8);
      CHECK(std::abs(seen.quality.height_mm) < 1e-8);
    }
  }
}

TEST_CASE("one reflector at the platform's centre zeroes the origin alone, as in the paper",
          "[measure][nests]") {
  NestFrame frame;
  frame.body = {{"centre", {0, 0, 0}}, {"arm", {80, 0, 0}}};
  const NestPose at_home = pose_of_nests({{"centre", {3, 4, 5}}}, frame, 0.005);
  const Eigen::Isometry3d T = zeroed(frame.T_B_T, at_home, {0, 0, 0});
  CHECK((T * Eigen::Vector3d(3, 4, 5)).norm() < 1e-12);
  CHECK(T.linear().isIdentity());
  const NestPose arm = pose_of_nests({{"arm", {83, 4, 5}}}, frame, 0.005);
  CHECK_THROWS_WITH(zeroed(frame.T_B_T, arm, {0, 0, 0}), Contains("phi not observed"));
}

TEST_CASE("a plane needs points off a line and an up that is not within it", "[measure][nests]") {
  const std::vector<Eigen::Vector3d> flat = {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}};
  CHECK_THROWS_WITH(frame_on_plane(fit_plane(flat), Eigen::Vector3d::UnitX()), Contains("up"));
  CHECK_THROWS_AS(frame_on_plane(Plane{}, Eigen::Vector3d::UnitZ()), InputError);
  const Eigen::Isometry3d below = frame_on_plane(fit_plane(flat), -Eigen::Vector3d::UnitZ());
  CHECK_THAT(below.linear()(2, 2), WithinAbs(-1, 1e-12));
  CHECK_THAT(below.linear().determinant(), WithinAbs(1, 1e-12));
}

TEST_CASE("a base at rest is called moved in no more than the stated share of checks",
          "[measure][nests]") {
  constexpr double kSigma = 0.006, kShare = 0.01;
  constexpr int kChecks = 20000;
  Random random(84);
  int alarms = 0;
  for (int k = 0; k < kChecks; ++k) {
    auto before = kBase, now = kBase;
    for (auto& p : before) p.at_mm += tests::noise_mm(random, kSigma);
    for (auto& p : now) p.at_mm += tests::noise_mm(random, kSigma);
    alarms += base_drift(before, now, Eigen::Isometry3d::Identity(), kSigma, kShare).moved ? 1 : 0;
  }
  INFO(alarms << " of " << kChecks);
  CHECK(alarms <= 243);  // binomial(20,000, 0.01): more in 0.1 % of runs
  CHECK(alarms >= 157);  // and no sleepy gate either
}

TEST_CASE("a base that moved is told how far, and as a move in the plane", "[measure][nests]") {
  Random random(85);
  const Eigen::Isometry3d T_T_B = tests::random_frame(random);
  Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
  move.linear() = Eigen::AngleAxisd(1e-4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  move.translation() << 0.05, -0.02, 0;
  const BaseDrift drift =
      base_drift(from(T_T_B, kBase), from(T_T_B, from(move, kBase)), T_T_B.inverse(), 0.006);
  CHECK(drift.moved);
  CHECK(drift.n_nests == 4);
  CHECK(drift.nest == "B1");
  CHECK_THAT(drift.largest_mm, WithinAbs(std::hypot(0.05 + 0.04, -0.02 - 0.05), 1e-5));
  CHECK_THAT(drift.shift.x_mm, WithinAbs(0.05, 1e-8));
  CHECK_THAT(drift.shift.y_mm, WithinAbs(-0.02, 1e-8));
  CHECK_THAT(drift.shift.phi_rad, WithinAbs(1e-4, 1e-10));
  CHECK_THROWS_WITH(base_drift({kBase[0]}, {kBase[1]}, T_T_B, 0.006), Contains("both times"));
}
