#include "core/mechanism/velocity.hpp"

#include "core/mechanism/forward.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

namespace {

/// A platform motion X(t) = X0 + V t + A t^2 / 2 and the joints that follow it.
struct Motion {
  Pose X0;
  Eigen::Vector3d V, A;
  [[nodiscard]] InverseResult at(const Geometry& g, double t) const {
    return inverse(g, Pose::from(X0.vector() + V * t + A * (t * t / 2)));
  }
};

Motion random_motion(Random& random) {
  return {tests::random_pose(random),
          {random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(-0.5, 0.5)},
          {random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(-0.5, 0.5)}};
}

}  // namespace

TEST_CASE("joint velocity is the time derivative of the inverse kinematics", "[mechanism]") {
  Random random(4);
  const double dt = 1e-5;
  for (int trial = 0; trial < 200; ++trial) {
    const Geometry g = tests::random_geometry(random);
    const Motion motion = random_motion(random);
    const auto rates = joint_velocity(g, motion.X0, motion.at(g, 0), motion.V);
    const auto plus = motion.at(g, dt), minus = motion.at(g, -dt);
    CHECK(((plus.l_mm - minus.l_mm) / (2 * dt) - rates.l).cwiseAbs().maxCoeff() < 1e-5);
    CHECK(((plus.theta_rad - minus.theta_rad) / (2 * dt) - rates.theta).cwiseAbs().maxCoeff() <
          1e-7);
  }
}

TEST_CASE("joint acceleration is the second derivative of the inverse kinematics", "[mechanism]") {
  Random random(5);
  const double dt = 1e-3;
  for (int trial = 0; trial < 200; ++trial) {
    const Geometry g = tests::random_geometry(random);
    const Motion motion = random_motion(random);
    const auto rates = joint_acceleration(g, motion.X0, motion.at(g, 0), motion.V, motion.A);
    const auto plus = motion.at(g, dt), zero = motion.at(g, 0), minus = motion.at(g, -dt);
    const Eigen::Vector3d l = (plus.l_mm - 2 * zero.l_mm + minus.l_mm) / (dt * dt);
    const Eigen::Vector3d t = (plus.theta_rad - 2 * zero.theta_rad + minus.theta_rad) / (dt * dt);
    CHECK((l - rates.l).cwiseAbs().maxCoeff() < 2e-3);
    CHECK((t - rates.theta).cwiseAbs().maxCoeff() < 1e-5);
  }
}

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
