#include "core/mechanism/inverse.hpp"

#include <cmath>
#include <numbers>

#include "tests/support/catch.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

namespace {
constexpr double kGoldenMm = 1e-9;
}

TEST_CASE("inverse kinematics gives the golden displacements and link angles", "[mechanism]") {
  const auto table = tests::read_table("core/mechanism/golden/inverse_nominal.csv");
  const Geometry geometry = paper_mechanism().geometry;
  REQUIRE(table.rows.size() > 50);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const auto result = inverse(geometry, {table.number(row, "x_mm"), table.number(row, "y_mm"),
                                           table.number(row, "phi_rad")});
    REQUIRE(result.ok());
    for (int i = 0; i < 3; ++i) {
      const std::string n = std::to_string(i + 1);
      CHECK_THAT(result.l_mm[i], WithinAbs(table.number(row, "l" + n + "_mm"), kGoldenMm));
      const double turn = result.theta_rad[i] - table.number(row, "theta" + n + "_rad");
      CHECK_THAT(std::remainder(turn, 2 * std::numbers::pi), WithinAbs(0, 1e-11));
    }
  }
}

TEST_CASE("at the centre every displacement is 261.8112 mm", "[mechanism]") {
  const auto result = inverse(paper_mechanism().geometry, Pose{});
  REQUIRE(result.ok());
  for (int i = 0; i < 3; ++i) CHECK_THAT(result.l_mm[i], WithinAbs(261.8112, 5e-5));
}

TEST_CASE("the loop closure holds at what inverse kinematics returns", "[mechanism]") {
  Random random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const Geometry geometry = tests::random_geometry(random, 5);
    const Pose pose = tests::random_pose(random);
    const auto result = inverse(geometry, pose);
    REQUIRE(result.ok());
    for (std::size_t i = 0; i < 3; ++i) {
      const Chain& c = geometry.chains[i];
      const double along = result.l_mm[static_cast<int>(i)] + c.l_zero_mm - c.R_mm;
      const double Bx = along * std::cos(c.alpha_rad) - c.h_mm * std::sin(c.alpha_rad);
      const double By = along * std::sin(c.alpha_rad) + c.h_mm * std::cos(c.alpha_rad);
      const double Cx = pose.x_mm + c.r_mm * std::cos(c.beta_rad + pose.phi_rad);
      const double Cy = pose.y_mm + c.r_mm * std::sin(c.beta_rad + pose.phi_rad);
      CHECK_THAT(std::hypot(Cx - Bx, Cy - By) - c.S_mm, WithinAbs(0, 1e-9));  // (1)
      CHECK_THAT(Bx + c.S_mm * std::cos(result.theta_rad[static_cast<int>(i)]),
                 WithinAbs(Cx, 1e-9));
    }
  }
}

TEST_CASE("an unreachable pose names the chain that cannot reach it", "[mechanism]") {
  const auto result = inverse(paper_mechanism().geometry, Pose{0, 700, 0});
  CHECK_FALSE(result.ok());
  CHECK(result.chain == 1);  // rail 1 points along -Y: it is the others that lack reach
}

TEST_CASE("a batch gives what single calls give", "[mechanism]") {
  Random random(2);
  const Geometry geometry = paper_mechanism().geometry;
  std::vector<Pose> poses{{0, 700, 0}};
  for (int i = 0; i < 50; ++i) poses.push_back(tests::random_pose(random));
  const auto batch = inverse(geometry, poses);
  REQUIRE(batch.size() == poses.size());
  CHECK_FALSE(batch[0].ok());
  for (std::size_t i = 1; i < poses.size(); ++i)
    CHECK(batch[i].l_mm == inverse(geometry, poses[i]).l_mm);
}
