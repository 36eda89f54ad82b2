#include "core/mechanism/displacements.hpp"

#include "core/mechanism/inverse.hpp"
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
