#include "core/mechanism/displacements.hpp"

#include "core/mechanism/inverse.hpp"
#include "core/mechanism/velocity.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

TEST_CASE("displacements of a batch are those of single calls, wherever a pose stands in it",
          "[mechanism]") {
  Random random(9);
  const Geometry geometry = tests::random_geometry(random, 3);
  const RailFrames frames = rail_frames(geometry);
  std::vector<Pose> poses;
  for (int i = 0; i < 101; ++i) poses.push_back(tests::random_pose(random));
  poses[5].phi_rad += 2 * kPi * 1e4;  // a tenth of a million turns is beyond the polynomials
  std::vector<Displacements> l(poses.size());
  CHECK(inverse_displacements(frames, poses, l) == poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i != 5) {
      CHECK((l[i] - inverse(geometry, poses[i]).l_mm).cwiseAbs().maxCoeff() < 1e-11);
    }
    CHECK(inverse_displacements(frames, poses[i]) == l[i]);
  }
  CHECK((l[5] - inverse(geometry, poses[5]).l_mm).cwiseAbs().maxCoeff() < 1e-8);
  poses[37] = {1000, 0, 0};
  poses[90] = {0, -1000, 0};
  CHECK(inverse_displacements(frames, poses, l) == 37);
  CHECK_FALSE(inverse_displacements(frames, poses[90]));
}

TEST_CASE("the chains at a pose are those of the inverse kinematics", "[mechanism]") {
  Random random(11);
  for (int trial = 0; trial < 200; ++trial) {
    const Geometry geometry = tests::random_geometry(random, 3);
    const Pose pose = tests::random_pose(random);
    const RailFrames frames = rail_frames(geometry);
    const InverseResult inv = inverse(geometry, pose);
    const ChainsAtPose at = chains_at(frames, pose.vector());
    REQUIRE(at.reached());
    CHECK((at.l_mm - inv.l_mm).cwiseAbs().maxCoeff() < 1e-11);
    CHECK((link_angles_rad(frames, at) - inv.theta_rad).cwiseAbs().maxCoeff() < 5e-12);
    const VelocityEquation one = velocity_equation(frames, at);
    const VelocityEquation other = velocity_equation(geometry, pose, inv);
    CHECK((one.J_F2 - other.J_F2).cwiseAbs().maxCoeff() < 1e-11);
    CHECK((one.J_F1_diagonal - other.J_F1_diagonal).cwiseAbs().maxCoeff() < 1e-13);
  }
  const RailFrames frames = rail_frames(paper_mechanism().geometry);
  CHECK(chains_at(frames, {0, 1000, 0}).missed ==
        inverse(paper_mechanism().geometry, {0, 1000, 0}).chain);
}

TEST_CASE("displacements of a batch are the same bits on every level of CPU", "[mechanism]") {
  Random random(10);
  const RailFrames frames = rail_frames(tests::random_geometry(random, 3));
  std::vector<Pose> poses;
  for (int i = 0; i < 1003; ++i) poses.push_back(tests::random_pose(random));
  std::vector<Displacements> baseline(poses.size()), l(poses.size());
  CHECK(inverse_displacements(frames, poses, baseline, CpuLevel::x86_64) == poses.size());
  for (const CpuLevel level : tests::levels_here()) {
    CHECK(inverse_displacements(frames, poses, l, level) == poses.size());
    CHECK(l == baseline);
  }
}
