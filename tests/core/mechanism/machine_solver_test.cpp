#include "core/mechanism/machine_solver.hpp"

#include <cmath>

#include "core/mechanism/clearance.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/velocity.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// About home, as far as every kind's starting machine goes.
Pose random_pose(const Machine& machine, Random& random) {
  Eigen::Vector3d X = machine.home.vector();
  const bool uvw = machine.kind->name == "3-PPR";
  for (int c = 0; c < machine.kind->n_chains; ++c) {
    X[c] += c == 2 ? random.uniform(-0.01, 0.01) : random.uniform(-1, 1) * (uvw ? 2 : 60);
  }
  return Pose::from(X);
}

}  // namespace

TEST_CASE("a 3-PRR is solved by its kernels, bit for bit", "[mechanism]") {
  const Mechanism mechanism = paper_mechanism();
  const MachineSolver solver(machine_of(mechanism));
  Random random(11);
  for (int k = 0; k < 50; ++k) {
    const Pose pose = random_pose(solver.machine(), random);
    const InverseResult at = inverse(mechanism.geometry, pose);
    CHECK(solver.drives(pose).l_mm == at.l_mm);
    CHECK(solver.drives(pose).theta_rad == at.theta_rad);
    CHECK(solver.pose(at.l_mm, {}).pose == forward(mechanism.geometry, at.l_mm).pose);
    CHECK_THAT(solver.look(pose).clearance_mm,
               WithinAbs(link_clearance_mm(mechanism.geometry, at), 1e-9));
  }
}

TEST_CASE("every kind of machine finds its pose again from the drives", "[mechanism]") {
  for (const MachineKind& kind : machine_kinds()) {
    INFO(kind.name);
    const MachineSolver solver(starting_machine(kind.name));
    Random random(12);
    for (int k = 0; k < 30; ++k) {
      const Pose pose = random_pose(solver.machine(), random);
      const InverseResult at = solver.drives(pose);
      REQUIRE(at.ok());
      const MachinePose back = solver.pose(at.l_mm, solver.machine().home);
      REQUIRE(back.ok());
      CHECK((back.pose.vector() - pose.vector()).cwiseAbs().maxCoeff() < 1e-9);
      CHECK(solver.look(pose).singularity.margin() > 0.01);
      // J_V against a small move of the first drive.
      constexpr double kStepMm = 1e-4;
      const Eigen::Vector3d step(kStepMm, 0, 0);
      const Eigen::Vector3d slope = (solver.pose(at.l_mm + step, pose).pose.vector() -
                                     solver.pose(at.l_mm - step, pose).pose.vector()) /
                                    (2 * kStepMm);
      CHECK((solver.look(pose).J_V.col(0) - slope).cwiseAbs().maxCoeff() < 1e-6);
    }
  }
}

TEST_CASE("cylinders keep clear of each other as links do; guides have none", "[mechanism]") {
  const MachineSolver cylinders(starting_machine("3-RPR"));
  // Bases at 400 mm, platform joints at 100 mm turned by 60 deg: a cylinder's platform joint lies
  // on the way of none; the platform's sides are the nearest, half a joint's distance away.
  const double clearance = cylinders.look({}).clearance_mm;
  CHECK(clearance > 10);
  CHECK(clearance < 100 * std::sqrt(3.0));
  CHECK(std::isinf(MachineSolver(starting_machine("XY")).look({}).clearance_mm));
}
