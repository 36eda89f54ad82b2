#include "core/mechanism/machine.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "core/error.hpp"
#include "core/mechanism/error_model.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

namespace {

/// What the independent prototype (dual numbers of its own) gave for a machine at a pose.
struct Golden {
  Machine machine;
  Pose pose;
  Displacements q_mm = Displacements::Zero();
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
  Eigen::Matrix3d J_V = Eigen::Matrix3d::Zero();
  std::map<std::pair<int, int>, double> J_e;  // by row, and column of all the chains' parameters
};

std::vector<Golden> golden_machines() {
  const auto table = tests::read_table("core/mechanism/golden/machines.csv");
  std::map<std::string, Golden> all;
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    Golden& g = all[table.text(k, "machine") + table.text(k, "pose")];
    g.machine.kind = find_machine_kind(table.text(k, "machine"));
    const std::string& what = table.text(k, "what");
    const int row = static_cast<int>(table.number(k, "row"));
    const int column = static_cast<int>(table.number(k, "column"));
    const double value = table.number(k, "value");
    if (what == "X") (row == 0 ? g.pose.x_mm : row == 1 ? g.pose.y_mm : g.pose.phi_rad) = value;
    if (what == "q") g.q_mm[row] = value;
    if (what == "forward") g.forward[row] = value;
    if (what == "J_V") g.J_V(row, column) = value;
    if (what == "J_e") g.J_e[{row, column}] = value;
    if (what == "p") {
      g.machine.chains[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = value;
    }
  }
  std::vector<Golden> list;
  for (const auto& [name, g] : all) list.push_back(g);
  return list;
}

auto near(double golden) { return WithinAbs(golden, 1e-12 * std::max(1.0, std::abs(golden))); }

/// A machine that no symmetry spares: every parameter off by some tolerances.
Machine erroneous(std::string_view kind, Random& random) {
  Machine machine = starting_machine(kind);
  for (const MachineParameter& p : parameters_of(*machine.kind)) {
    machine.chains[static_cast<std::size_t>(p.chain)][p.place] += 3 * p.tolerance * random.normal();
  }
  return machine;
}

/// Within `share` of the stroke about home, along the machine's own coordinates.
Pose pose_about_home(const Machine& machine, Random& random, double share) {
  const Limits& l = machine.drives[0].limits;
  const double reach_mm = share * (l.l_max_mm - l.l_min_mm);
  const int n = machine.kind->n_chains;
  Pose pose = machine.home;
  pose.x_mm += random.uniform(-reach_mm, reach_mm);
  if (n > 1) pose.y_mm += random.uniform(-reach_mm, reach_mm);
  if (n > 2) pose.phi_rad += random.uniform(-reach_mm, reach_mm) / 300;
  return pose;
}

const std::vector<std::string> kNames = {"3-PRR", "3-PPR", "3-RPR", "XY", "X"};

}  // namespace

TEST_CASE("every kind of machine gives the golden drives, Jacobians and poses", "[mechanism]") {
  const std::vector<Golden> all = golden_machines();
  REQUIRE(all.size() == 10);
  for (const Golden& g : all) {
    CAPTURE(g.machine.kind->name);
    const int n = g.machine.kind->n_chains;
    const DrivesAt at = drives_at(g.machine, g.pose);
    REQUIRE(at.reached());
    const Closures here = closures(g.machine, at.q_mm, g.pose);
    const Eigen::Matrix3d J_V = velocity_jacobian(here);
    const ParameterColumns J_e = error_jacobian(here);
    Pose start = g.pose;
    start.x_mm += 1;
    const MachinePose back = forward(g.machine, g.q_mm, start);
    REQUIRE(back.ok());
    for (int i = 0; i < n; ++i) {
      CHECK_THAT(at.q_mm[i], near(g.q_mm[i]));
      CHECK_THAT(back.pose.vector()[i], near(g.forward[i]));
      for (int j = 0; j < n; ++j) CHECK_THAT(J_V(i, j), near(g.J_V(i, j)));
      const auto& parameters = parameters_of(*g.machine.kind);
      for (std::size_t k = 0; k < parameters.size(); ++k) {
        const int column =
            parameters[k].chain * static_cast<int>(g.machine.kind->chain->parameters.size()) +
            static_cast<int>(parameters[k].place);
        CHECK_THAT(J_e(i, static_cast<Eigen::Index>(k)), near(g.J_e.at({i, column})));
      }
    }
  }
}

TEST_CASE("both Jacobians are derivatives of the forward kinematics of every machine",
          "[mechanism]") {
  Random random(21);
  for (const std::string& kind : kNames) {
    CAPTURE(kind);
    const Machine machine = erroneous(kind, random);
    const Pose pose = pose_about_home(machine, random, 0.15);
    const Displacements q = drives_at(machine, pose).q_mm;
    const Closures here = closures(machine, q, pose);
    const Eigen::Matrix3d J_V = velocity_jacobian(here);
    const ParameterColumns J_e = error_jacobian(here);
    const auto slope = [&](const Machine& plus, const Machine& minus, const Displacements& dq,
                           double step) -> Eigen::Vector3d {
      const MachinePose a = forward(plus, q + dq, pose), b = forward(minus, q - dq, pose);
      REQUIRE((a.ok() && b.ok()));
      return (a.pose.vector() - b.pose.vector()) / (2 * step);
    };
    for (int i = 0; i < machine.kind->n_chains; ++i) {
      const Displacements dq = Displacements::Unit(i) * 1e-4;
      CHECK((slope(machine, machine, dq, 1e-4) - J_V.col(i)).cwiseAbs().maxCoeff() < 1e-7);
    }
    const auto& parameters = parameters_of(*machine.kind);
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const double step = parameters[k].is_angle ? 1e-7 : 1e-4;
      Machine plus = machine, minus = machine;
      plus.chains[static_cast<std::size_t>(parameters[k].chain)][parameters[k].place] += step;
      minus.chains[static_cast<std::size_t>(parameters[k].chain)][parameters[k].place] -= step;
      const Eigen::Vector3d column = J_e.col(static_cast<Eigen::Index>(k));
      CHECK((slope(plus, minus, Displacements::Zero(), step) - column).cwiseAbs().maxCoeff() <
            1e-6 * (1 + column.cwiseAbs().maxCoeff()));
    }
  }
}

TEST_CASE("drives and links move as the inverse kinematics does in time", "[mechanism]") {
  Random random(22);
  const double dt = 1e-3;
  for (const std::string& kind : kNames) {
    for (int trial = 0; trial < 20; ++trial) {
      CAPTURE(kind, trial);
      const Machine machine = erroneous(kind, random);
      const Pose X = pose_about_home(machine, random, 0.1);
      const Eigen::Vector3d V(random.uniform(-50, 50), random.uniform(-50, 50),
                              random.uniform(-0.5, 0.5));
      const Eigen::Vector3d A(random.uniform(-50, 50), random.uniform(-50, 50),
                              random.uniform(-0.5, 0.5));
      const auto at = [&](double t) {
        return drives_at(machine, Pose::from(X.vector() + V * t + A * (t * t / 2)));
      };
      const DrivesAt now = drives_at(machine, X, V, A), plus = at(dt), minus = at(-dt);
      REQUIRE((now.reached() && plus.reached() && minus.reached()));
      const auto check = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& z,
                             const Eigen::Vector3d& m, const Eigen::Vector3d& velocity,
                             const Eigen::Vector3d& acceleration, double unit) {
        CHECK(((p - m) / (2 * dt) - velocity).cwiseAbs().maxCoeff() < 5e-3 * unit);
        CHECK(((p - 2 * z + m) / (dt * dt) - acceleration).cwiseAbs().maxCoeff() < 2e-2 * unit);
      };
      check(plus.q_mm, now.q_mm, minus.q_mm, now.velocity_mm_s, now.acceleration_mm_s2, 1);
      CHECK(now.angle.has_value() == (kind == "3-PRR" || kind == "3-RPR"));
      if (!now.angle) continue;
      check((*plus.angle)[0], (*now.angle)[0], (*minus.angle)[0], (*now.angle)[1], (*now.angle)[2],
            1e-2);
    }
  }
}

TEST_CASE("the kernels of the 3-PRR are the generic kinematics to 1e-12", "[mechanism]") {
  Random random(23);
  for (int trial = 0; trial < 300; ++trial) {
    Mechanism mechanism = paper_mechanism();
    mechanism.geometry = tests::random_geometry(random, 3);
    const Machine machine = machine_of(mechanism);
    const RailFrames rails = rail_frames(mechanism.geometry);
    const Pose pose = tests::random_pose(random);
    const ChainsAtPose fast = chains_at(rails, pose.vector());
    const DrivesAt at = drives_at(machine, pose);
    REQUIRE(at.reached());
    const auto differ = [](const auto& a, const auto& b) {
      return (a - b).cwiseAbs().maxCoeff() / std::max(1.0, b.cwiseAbs().maxCoeff());
    };
    CHECK(differ(at.q_mm, fast.l_mm) < 1e-12);
    CHECK(differ((*at.angle)[0], link_angles_rad(rails, fast)) < 1e-12);
    const Closures here = closures(machine, fast.l_mm, pose);
    const VelocityEquation equation = velocity_equation(rails, fast);
    CHECK(differ(velocity_jacobian(here), velocity_jacobian(equation)) < 1e-12);
    CHECK(differ(error_jacobian(here), error_jacobian(rails, fast)) < 1e-12);
    CHECK_THAT(singularity(machine, here).margin(),
               WithinAbs(singularity(mechanism.geometry, equation).margin(), 1e-12));
    const MachinePose back = forward(machine, fast.l_mm, {});
    REQUIRE(back.ok());
    CHECK(differ(back.pose.vector(), forward(rails, fast.l_mm).pose.vector()) < 1e-10);
  }
}

TEST_CASE("forward finds every pose of the stroke again, in the assembly of its start",
          "[mechanism]") {
  for (const std::string& kind : kNames) {
    const Machine machine = starting_machine(kind);
    const Limits& l = machine.drives[0].limits;
    const double half = 0.75 * (l.l_max_mm - l.l_min_mm);
    const double turn_deg = kind == "3-PPR" ? 0.25 : 15;  // its joints move by 100 mm a radian
    int n = 0, missed = 0, elsewhere = 0;
    for (int x = -6; x <= 6; ++x) {
      for (int y = -6; y <= 6; ++y) {
        for (int turn = -12; turn <= 12; ++turn) {
          Pose pose = machine.home;
          pose.x_mm += x * half / 6;
          if (machine.kind->n_chains > 1) pose.y_mm += y * half / 6;
          if (machine.kind->n_chains > 2) pose.phi_rad = rad_from_deg(turn * turn_deg + 0.1);
          const Reach at = reach(machine, pose);
          if (!at.ok() || at.singularity.margin() < 1e-3) continue;
          ++n;
          const MachinePose found = forward(machine, at.at.q_mm, machine.home);
          missed += found.ok() ? 0 : 1;
          if (!found.ok()) continue;
          const Reach back = reach(machine, found.pose);
          REQUIRE(back.assembly == 1);
          CHECK((back.at.q_mm - at.at.q_mm).cwiseAbs().maxCoeff() < 1e-8);
          CHECK(std::abs(found.pose.phi_rad) <= kPi);
          if ((found.pose.vector() - pose.vector()).norm() > 1e-6) ++elsewhere;
        }
      }
    }
    CAPTURE(kind, n, missed, elsewhere);
    CHECK(n > 100);
    CHECK(missed == 0);
    CHECK(elsewhere <= n / 100);  // another pose of the same drives in the same assembly
  }
}

TEST_CASE("forward says where no pose of its assembly is, and that its start is singular",
          "[mechanism]") {
  const Machine machine = starting_machine("3-PRR");
  const MachinePose none = forward(machine, {1, 600, 0}, machine.home);
  CHECK(none.status == MachinePose::Status::unreachable);
  CHECK_FALSE(forward(machine, {NAN, 261, 261}, machine.home).ok());
  const MachinePose singular = forward(machine, {261, 261, 261}, {0, 0, rad_from_deg(60)});
  CHECK(singular.status == MachinePose::Status::singular);
  const Pose beyond{10, 5, rad_from_deg(100)};
  const Reach there = reach(machine, beyond);
  REQUIRE(there.assembly == -1);
  const MachinePose other = forward(machine, there.at.q_mm, {0, 0, rad_from_deg(90)});
  REQUIRE(other.ok());
  CHECK((other.pose.vector() - beyond.vector()).norm() < 1e-9);
  CHECK(reach(machine, forward(machine, there.at.q_mm, machine.home).pose).assembly == 1);
}

TEST_CASE("a machine that cannot be used is refused by its field", "[mechanism]") {
  for (const std::string& kind : kNames) CHECK_NOTHROW(validate(starting_machine(kind)));
  CHECK_THROWS_AS(starting_machine("3-RRR"), NotFoundError);
  const auto refused = [](Machine machine, auto change, const std::string& field) {
    change(machine);
    std::string got = "nothing";
    try {
      validate(machine);
    } catch (const InputError& error) {
      got = error.text().where.field;
    }
    CHECK(got == field);
  };
  const Machine uvw = starting_machine("3-PPR"), rpr = starting_machine("3-RPR");
  refused(
      uvw, [](Machine& m) { m.chains[1][1] = m.chains[1][0]; }, "chains[1]");
  refused(
      uvw, [](Machine& m) { m.chains[2][1] = NAN; }, "chains[2].gamma_deg");
  refused(
      rpr, [](Machine& m) { m.chains[0][3] = 0; }, "chains[0].r_mm");
  refused(
      rpr, [](Machine& m) { m.drives[2].lead_mm = 0; }, "drives[2].lead_mm");
  refused(
      rpr,
      [](Machine& m) {
        m.drives[1].limits = {5, 5};
      },
      "drives[1].limits.l_max_mm");
  refused(
      rpr, [](Machine& m) { m.measured = {}; }, "measured");
  refused(
      starting_machine("XY"), [](Machine& m) { m.chains[0][4] = 10; }, "chains[0].r_mm");
  // similar triangles in the same orientation; all guides parallel; an axis across its own guide
  const auto similar = [](Machine& m) {
    for (ChainValues& p : m.chains) p[4] = std::atan2(p[1], p[0]);
  };
  refused(rpr, similar, "home");
  refused(
      uvw, [](Machine& m) { m.chains[2] = m.chains[0]; }, "home");
  refused(
      starting_machine("X"),
      [](Machine& m) {
        m.chains[0] = {rad_from_deg(90), 0};
      },
      "home");
}

TEST_CASE("the paper's robot goes into a machine and back", "[mechanism]") {
  Random random(24);
  Mechanism mechanism = paper_mechanism();
  mechanism.geometry = tests::random_geometry(random);
  mechanism.home = {1, -2, 0.01};
  Machine machine = machine_of(mechanism);
  CHECK(to_vector(mechanism_of(machine).geometry) == to_vector(mechanism.geometry));
  CHECK(mechanism_of(machine).home == mechanism.home);
  CHECK(machine == machine_of(mechanism));
  machine.drives[2].lead_mm = 5;
  CHECK_THROWS_WITH(mechanism_of(machine), Contains("drives differ"));
  CHECK_THROWS_WITH(mechanism_of(starting_machine("XY")), Contains("3-PRR alone"));
}
