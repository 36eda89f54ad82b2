#include "core/mechanism/forward.hpp"

#include "core/mechanism/inverse.hpp"
#include "tests/support/catch.hpp"
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

TEST_CASE("a batch of displacements gives what single calls give", "[mechanism]") {
  const Geometry geometry = paper_mechanism().geometry;
  const std::vector<Displacements> all = {{261, 262, 263}, {250, 270, 260}};
  const auto batch = forward(geometry, all);
  REQUIRE(batch.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) CHECK(batch[i].pose == forward(geometry, all[i]).pose);
}
