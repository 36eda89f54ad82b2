#include "core/mechanism/forward.hpp"

#include <algorithm>

#include "core/mechanism/error_rows.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/mechanism/poses.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

namespace {

Geometry perturbed_geometry() {
  const auto table = tests::read_table("core/mechanism/golden/perturbed_geometry.csv");
  Geometry geometry;
  for (std::size_t i = 0; i < 3; ++i) {
    geometry.chains[i] = {table.number(i, "alpha_rad"),
                          table.number(i, "beta_rad"),
                          table.number(i, "r_mm"),
                          table.number(i, "S_mm"),
                          table.number(i, "dl_mm"),
                          table.number(i, "R_mm"),
                          0};
  }
  return geometry;
}

}  // namespace

TEST_CASE("forward kinematics of an erroneous mechanism gives the golden poses", "[mechanism]") {
  const auto table = tests::read_table("core/mechanism/golden/forward_perturbed.csv");
  const Geometry geometry = perturbed_geometry();
  REQUIRE(table.rows.size() > 50);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const auto result = forward(geometry, {table.number(row, "l1_mm"), table.number(row, "l2_mm"),
                                           table.number(row, "l3_mm")});
    REQUIRE(result.ok());
    CHECK_THAT(result.pose.x_mm, WithinAbs(table.number(row, "x_mm"), 1e-9));
    CHECK_THAT(result.pose.y_mm, WithinAbs(table.number(row, "y_mm"), 1e-9));
    CHECK_THAT(result.pose.phi_rad, WithinAbs(table.number(row, "phi_rad"), 1e-11));
  }
}

TEST_CASE("inverse then forward returns the pose everywhere in the workspace", "[mechanism]") {
  Random random(3);
  int most = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Geometry geometry = tests::random_geometry(random, 5);
    const Pose pose = tests::random_pose(random);
    const auto there = inverse(geometry, pose);
    REQUIRE(there.ok());
    const auto back = forward(geometry, there.l_mm);
    REQUIRE(back.ok());
    CHECK((back.pose.vector() - pose.vector()).cwiseAbs().maxCoeff() < 1e-9);
    most = std::max(most, back.iterations);
  }
  CHECK(most <= 9);  // quadratic convergence
}

TEST_CASE("displacements no pose can have are refused, not iterated for ever", "[mechanism]") {
  const auto result = forward(paper_mechanism().geometry, {0, 600, 600});
  CHECK_FALSE(result.ok());
  CHECK_FALSE(forward(paper_mechanism().geometry, {NAN, 261, 261}).ok());
}

TEST_CASE("poses of a table are those of single calls, wherever one stands and on every level",
          "[mechanism]") {
  Random random(13);
  const Geometry geometry = tests::random_geometry(random, 3);
  const RailFrames rails = rail_frames(geometry);
  std::vector<Displacements> l;
  std::vector<Pose> starts;
  for (int k = 0; k < 83; ++k) {
    const Pose truth = tests::random_pose(random);
    l.push_back(inverse(geometry, truth).l_mm);
    starts.push_back({truth.x_mm + random.uniform(-5, 5), truth.y_mm + random.uniform(-5, 5),
                      truth.phi_rad + random.uniform(-0.05, 0.05)});
  }
  l[7] = Displacements::Constant(5000);  // out of reach
  starts[20] = {0, 5000, 0};             // from where no step leads
  l[82] = {NAN, 261, 261};
  const std::vector<std::size_t> lost = {7, 20, 82};
  std::vector<Pose> poses = starts;
  CHECK(poses_at(rails, l, poses) == lost);
  for (std::size_t k = 0; k < l.size(); ++k) {
    CAPTURE(k);
    const ForwardResult single = forward(rails, l[k], starts[k]);
    REQUIRE(single.ok() == !std::ranges::binary_search(lost, k));
    if (!single.ok()) continue;
    CHECK((poses[k].vector() - single.pose.vector()).cwiseAbs().maxCoeff() < 1e-9);
    std::vector<Pose> alone = {starts[k]};
    REQUIRE(poses_at(rails, std::span(&l[k], 1), alone).empty());
    CHECK(alone[0] == poses[k]);
  }
  for (const CpuLevel level : tests::levels_here()) {
    std::vector<Pose> again = starts;
    CHECK(poses_at(rails, l, again, level) == lost);
    for (std::size_t k = 0; k < l.size(); ++k) {
      if (!std::ranges::binary_search(lost, k)) CHECK(again[k] == poses[k]);
    }
  }
}

TEST_CASE("a pose that only shorter steps find is found in a table too", "[mechanism]") {
  const Geometry geometry = paper_mechanism().geometry;
  const RailFrames rails = rail_frames(geometry);
  Random random(14);
  int shortened = 0;
  for (int k = 0; k < 2000; ++k) {
    const Displacements l = inverse(geometry, tests::random_pose(random)).l_mm;
    const Pose start{random.uniform(-300, 300), random.uniform(-300, 300), random.uniform(-2, 2)};
    const ForwardResult single = forward(rails, l, start);
    std::vector<Pose> found = {start};
    REQUIRE(poses_at(rails, std::span(&l, 1), found).empty() == single.ok());
    std::vector<Pose> by_whole_steps = {start};
    Eigen::MatrixXd J;
    const bool whole = error_rows(rails, std::span(&l, 1), by_whole_steps, J).empty();
    if (single.ok() && !whole) ++shortened;
  }
  CHECK(shortened > 0);
}
