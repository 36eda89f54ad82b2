#include "core/mechanism/velocity.hpp"

#include "core/mechanism/forward.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

TEST_CASE("the velocity Jacobian is the derivative of the forward kinematics", "[mechanism]") {
  Random random(6);
  const double dl = 1e-4;
  for (int trial = 0; trial < 200; ++trial) {
    const Geometry g = tests::random_geometry(random);
    const Pose pose = tests::random_pose(random);
    const auto at = inverse(g, pose);
    const Eigen::Matrix3d J_V = velocity_jacobian(velocity_equation(g, pose, at));
    for (int k = 0; k < 3; ++k) {
      const Displacements step = Displacements::Unit(k) * dl;
      const Eigen::Vector3d difference = forward(g, at.l_mm + step, pose).pose.vector() -
                                         forward(g, at.l_mm - step, pose).pose.vector();
      CHECK((difference / (2 * dl) - J_V.col(k)).cwiseAbs().maxCoeff() < 1e-7);
    }
  }
}

TEST_CASE(
    "the singularity margin is 1 only at best and vanishes where a link stands across its rail",
    "[mechanism]") {
  const Geometry g = paper_mechanism().geometry;
  const auto centre = inverse(g, Pose{});
  const auto far = singularity(g, velocity_equation(g, Pose{}, centre));
  CHECK(far.margin() > 0.3);
  CHECK(far.margin() <= 1);
  InverseResult across = centre;
  across.theta_rad[0] = g.chains[0].alpha_rad + kPi / 2;
  CHECK_THAT(singularity(g, velocity_equation(g, Pose{}, across)).serial, WithinAbs(0, 1e-12));
  InverseResult parallel = centre;  // three parallel links: no force across them
  parallel.theta_rad.setConstant(0.3);
  CHECK_THAT(singularity(g, velocity_equation(g, Pose{}, parallel)).parallel, WithinAbs(0, 1e-12));
}
