// Kinematics from the command line.

#include <nlohmann/json.hpp>

#include "core/mechanism/error_model.hpp"
#include "core/mechanism/velocity.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_program;

namespace {

using OrderedJson = nlohmann::ordered_json;

const std::string kMechanismRobot = tests::source_folder() + "/examples/paper/robot.json";

Finished mechanism(std::vector<std::string> words) {
  const tests::TemporaryFolder folder;
  words.insert(words.begin(), "mechanism");
  words.insert(words.begin() + 2, kMechanismRobot);
  return run_program(words, folder.path());
}

}  // namespace

TEST_CASE("whole plans and files of commands are solved at once, there and back", "[cli]") {
  const Finished there = mechanism({"ik", "--plan", "paper-80", "--json"});
  REQUIRE(there.exit_code == 0);
  const OrderedJson poses = OrderedJson::parse(there.out).at("poses");
  REQUIRE(poses.size() == 80);
  std::string csv = "cmd_l1_mm,cmd_l2_mm,cmd_l3_mm\n";
  for (const OrderedJson& p : poses) {
    csv += p["l_mm"][0].dump() + "," + p["l_mm"][1].dump() + "," + p["l_mm"][2].dump() + "\n";
  }
  const tests::TemporaryFolder folder;
  const std::string file = folder.write("l.csv", csv).string();
  const Finished back = mechanism({"fk", "--commands", file, "--json"});
  REQUIRE(back.exit_code == 0);
  const OrderedJson found = OrderedJson::parse(back.out).at("displacements");
  REQUIRE(found.size() == 80);
  for (std::size_t k = 0; k < found.size(); ++k) {
    for (const char* at : {"x_mm", "y_mm", "phi_deg"}) {
      CHECK_THAT(found[k]["pose"][at].get<double>(),
                 WithinAbs(poses[k]["pose"][at].get<double>(), 1e-9));
    }
  }
}

TEST_CASE("a pose or displacements out of reach name the chain and end with 5", "[cli]") {
  const Finished pose = mechanism({"ik", "--pose", "0", "0", "0", "600", "0", "0"});
  CHECK(pose.exit_code == 5);
  CHECK_THAT(pose.out, Contains("261.811206") && Contains("unreachable, chain 1"));
  const Finished l = mechanism({"fk", "--l", "1", "600", "0"});
  CHECK(l.exit_code == 5);
  CHECK_THAT(l.out, Contains(", chain "));
  CHECK(mechanism({"fk", "--l", "261.81120622694624", "261.81120622694624", "261.8112062269463"})
            .out.find("-0.0000") == std::string::npos);
  CHECK(mechanism({"ik"}).exit_code == 2);
}

TEST_CASE("joint rates and both Jacobians are those of the library", "[cli]") {
  const Finished answer =
      mechanism({"ik", "--pose", "30", "-40", "2", "--velocity", "10", "-5", "3", "--acceleration",
                 "1", "2", "-4", "--jacobians", "--json"});
  REQUIRE(answer.exit_code == 0);
  const OrderedJson row = OrderedJson::parse(answer.out).at("poses")[0];
  const Geometry geometry = paper_mechanism().geometry;
  const Pose pose{30, -40, rad_from_deg(2)};
  const InverseResult at = inverse(geometry, pose);
  const RailFrames frames = rail_frames(geometry);
  const Eigen::Vector3d v(10, -5, rad_from_deg(3)), a(1, 2, rad_from_deg(-4));
  const JointRates velocity = joint_velocity(geometry, pose, at, v);
  const JointRates acceleration = joint_acceleration(geometry, pose, at, v, a);
  const Eigen::Matrix3d J_V = velocity_jacobian(velocity_equation(geometry, pose, at));
  const ErrorJacobian J_e = error_jacobian(frames, chains_at(frames, pose.vector()));
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    CHECK_THAT(row["l_velocity_mm_s"][i].get<double>(), WithinRel(velocity.l[k], 1e-12));
    CHECK_THAT(row["theta_velocity_deg_s"][i].get<double>(),
               WithinRel(deg_from_rad(velocity.theta[k]), 1e-12));
    CHECK_THAT(row["l_acceleration_mm_s2"][i].get<double>(), WithinRel(acceleration.l[k], 1e-12));
    for (std::size_t j = 0; j < 3; ++j) {
      CHECK(row["J_V_mm_rad"][i][j] == J_V(k, static_cast<Eigen::Index>(j)));
    }
    REQUIRE(row["J_e_mm_rad"][i].size() == 21);
    for (std::size_t j = 0; j < 21; ++j) {
      CHECK(row["J_e_mm_rad"][i][j] == J_e(k, static_cast<Eigen::Index>(j)));
    }
  }
}

TEST_CASE("sensitivity and workspace say on what grid, at what sizes, and how much", "[cli]") {
  CHECK_THAT(mechanism({"sensitivity"}).out,
             Contains("441 poses") && Contains("0.001 deg and 0.05 mm") && Contains("chain 3"));
  CHECK_THAT(mechanism({"workspace", "--step", "50", "--half-width", "300"}).out,
             Contains("x from -300 to 300 mm") && Contains("of 169 poses are reachable"));
}
