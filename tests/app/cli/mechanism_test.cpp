// Kinematics from the command line.

#include <nlohmann/json.hpp>

#include "app/files/machine_json.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
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

TEST_CASE("rates and both Jacobians are those of the library, for every kind of machine", "[cli]") {
  for (const MachineKind& kind : machine_kinds()) {
    CAPTURE(kind.name);
    const Machine machine = starting_machine(kind.name);
    const tests::TemporaryFolder folder;
    folder.write("m.json", machine_json(machine).dump());
    const Eigen::Vector3d typed(2, -3, 1), v(10, -5, 3), a(1, 2, -4);
    std::vector<std::string> words = {"mechanism", "ik", "m.json", "--jacobians", "--json"};
    const auto add = [&](const char* option, const Eigen::Vector3d& numbers) {
      words.emplace_back(option);
      for (int i = 0; i < kind.n_chains; ++i) words.push_back(std::to_string(numbers[i]));
    };
    add("--pose", typed);
    add("--velocity", v);
    add("--acceleration", a);
    const Finished answer = run_program(words, folder.path());
    REQUIRE(answer.exit_code == 0);
    const OrderedJson row = OrderedJson::parse(answer.out).at("poses")[0];
    const auto inside = [&](Eigen::Vector3d x) {  // rad, and only what the machine has
      for (int i = kind.n_chains; i < 3; ++i) x[i] = 0;
      x[2] = rad_from_deg(x[2]);
      return x;
    };
    const Pose pose = Pose::from(inside(typed));
    const DrivesAt at = drives_at(machine, pose, inside(v), inside(a));
    const Closures here = closures(machine, at.q_mm, pose);
    const Eigen::Matrix3d J_V = velocity_jacobian(here);
    const ParameterColumns J_e = error_jacobian(here);
    CHECK(row["pose"].size() == static_cast<std::size_t>(kind.n_chains));
    CHECK(row["assembly"] == "home");
    REQUIRE(row["l_mm"].size() == static_cast<std::size_t>(kind.n_chains));
    REQUIRE(row["J_e_mm_rad"].size() == static_cast<std::size_t>(kind.n_chains));
    for (Eigen::Index i = 0; i < kind.n_chains; ++i) {
      const auto k = static_cast<std::size_t>(i);
      CHECK(row["l_mm"][k] == at.q_mm[i]);
      CHECK(row["l_velocity_mm_s"][k] == at.velocity_mm_s[i]);
      CHECK(row["l_acceleration_mm_s2"][k] == at.acceleration_mm_s2[i]);
      if (at.angle) CHECK(row["theta_velocity_deg_s"][k] == deg_from_rad((*at.angle)[1][i]));
      for (Eigen::Index j = 0; j < kind.n_chains; ++j) {
        CHECK(row["J_V_mm_rad"][k][static_cast<std::size_t>(j)] == J_V(i, j));
      }
      REQUIRE(row["J_e_mm_rad"][k].size() == parameters_of(kind).size());
      for (Eigen::Index j = 0; j < J_e.cols(); ++j) {
        CHECK(row["J_e_mm_rad"][k][static_cast<std::size_t>(j)] == J_e(i, j));
      }
    }
  }
}

TEST_CASE("every verb answers for every kind of machine, in text and under its schema", "[cli]") {
  for (const MachineKind& kind : machine_kinds()) {
    CAPTURE(kind.name);
    const tests::TemporaryFolder folder;
    folder.write("m.json", machine_json(starting_machine(kind.name)).dump());
    const auto n = static_cast<std::size_t>(kind.n_chains);
    const std::vector<std::string> numbers(n, "1");
    const DrivesAt home = drives_at(starting_machine(kind.name), {});
    std::vector<std::string> l;
    for (std::size_t i = 0; i < n; ++i) {
      l.push_back(std::to_string(home.q_mm[static_cast<Eigen::Index>(i)]));
    }
    const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
      words.insert(words.end(), more.begin(), more.end());
      return words;
    };
    const std::vector<std::vector<std::string>> verbs = {
        {"check"},
        with({"ik", "--pose"}, numbers),
        with({"fk", "--l"}, l),
        {"sensitivity", "--half-width", "4", "--step", "2"},
        {"workspace", "--half-width", "4", "--step", "2"}};
    for (const std::vector<std::string>& verb : verbs) {
      CAPTURE(verb.front());
      std::vector<std::string> words = {"mechanism", verb.front(), "m.json"};
      words.insert(words.end(), verb.begin() + 1, verb.end());
      CHECK(run_program(words, folder.path()).exit_code == 0);
      words.emplace_back("--json");
      const Finished answer = run_program(words, folder.path());
      REQUIRE(answer.exit_code == 0);
      CHECK(answer.out.find("null") == std::string::npos);
      CHECK(tests::schema_errors(nlohmann::json::parse(answer.out),
                                 "mechanism-" + verb.front() + ".schema.json") == "");
    }
  }
}

TEST_CASE("check gives each machine's ranks, and what is never told in words", "[cli]") {
  const tests::TemporaryFolder folder;
  folder.write("uvw.json", machine_json(starting_machine("3-PPR")).dump());
  const Finished uvw = run_program({"mechanism", "check", "uvw.json"}, folder.path());
  CHECK_THAT(uvw.out, Contains("orientation constant: rank 6 of 18") &&
                          Contains("orientation varied: rank 12 of 18") &&
                          Contains("alpha_1 is not identified"));
  CHECK_THAT(mechanism({"check"}).out, Contains("orientation constant: rank 12 of 21") &&
                                           Contains("rank 15 of 18 (the paper's)") &&
                                           Contains("l_1 and R_1 act as one"));
}

TEST_CASE("a pose beyond a singularity is not ok, and no number there is null", "[cli]") {
  const Finished at = mechanism(
      {"ik", "--pose", "0", "0", "60", "--jacobians", "--velocity", "1", "2", "3", "--json"});
  CHECK(at.exit_code == 5);
  CHECK(at.out.find("null") == std::string::npos);
  const OrderedJson row = OrderedJson::parse(at.out).at("poses")[0];
  CHECK(row["status"] == "singular");
  CHECK(row["assembly"] == "none");
  CHECK_FALSE(row.contains("J_V_mm_rad"));
  const Finished beyond = mechanism({"ik", "--pose", "0", "0", "70"});
  CHECK(beyond.exit_code == 5);
  CHECK_THAT(beyond.out, Contains("other assembly"));
  const OrderedJson map = OrderedJson::parse(
      mechanism({"workspace", "--phi", "70", "--half-width", "150", "--json"}).out);
  int listed = 0;
  for (const OrderedJson& cell : map["cells"]) listed += cell["status"] == "ok" ? 1 : 0;
  CHECK(map["n_reachable"] == listed);
  CHECK(listed < 30);
}

TEST_CASE("fk starts where it is asked to, stays in that assembly, and wraps phi", "[cli]") {
  const std::vector<std::string> l = {"fk", "--l", "261.8", "261.8", "261.8"};
  const auto from = [&l](const std::vector<std::string>& start) {
    std::vector<std::string> words = l;
    words.emplace_back("--json");
    words.emplace_back("--start");
    words.insert(words.end(), start.begin(), start.end());
    return mechanism(words);
  };
  const OrderedJson turned = OrderedJson::parse(from({"0", "0", "365"}).out).at("displacements")[0];
  CHECK(turned["assembly"] == "home");
  CHECK_THAT(turned["pose"]["phi_deg"].get<double>(), WithinAbs(0, 1));
  const Finished other = from({"0", "0", "115"});
  CHECK(other.exit_code == 5);
  const OrderedJson there = OrderedJson::parse(other.out).at("displacements")[0];
  CHECK(there["status"] == "other assembly");
  CHECK(there["pose"]["phi_deg"].get<double>() > 60);
  CHECK(from({"0", "0", "60"}).exit_code == 5);
  CHECK(from({"0", "0"}).exit_code == 2);
}

TEST_CASE("sensitivity and workspace say on what grid, at what sizes, and how much", "[cli]") {
  CHECK_THAT(mechanism({"sensitivity"}).out,
             Contains("441 poses") && Contains("0.001 deg and 0.05 mm") && Contains("chain 3"));
  CHECK_THAT(mechanism({"workspace", "--step", "50", "--half-width", "300"}).out,
             Contains("x from -300 to 300 mm") && Contains("of 169 poses are reachable"));
}

TEST_CASE("beyond what was fitted a compensation and a model warn, before anything moves",
          "[cli]") {
  const tests::TemporaryFolder folder;
  const auto run = [&folder](const std::vector<std::string>& words) {
    return run_program(words, folder.path());
  };
  REQUIRE(run({"campaign", "import", tests::kDriveError}).exit_code == 0);
  REQUIRE(run({"diagnose", "drive-error", "--replicates", "500"}).exit_code == 0);
  REQUIRE(run({"plan", "create", "lattice", "--half-width", "120", "--step", "120", "--out",
               "wide.json"})
              .exit_code == 0);
  const std::vector<std::string> session = {"session",
                                            "run",
                                            "drive-error",
                                            "--plan",
                                            "wide.json",
                                            "--stage",
                                            "sim:" + kMechanismRobot,
                                            "--compensate",
                                            "1",
                                            "--dry-run"};
  CHECK_THAT(run(session).err, Contains("warning: 8 of 9 targets of the plan lie outside"));
  const Finished inside = run({"model", "predict", "drive-error", "last", "--pose", "10,20,0"});
  CHECK(inside.exit_code == 0);
  CHECK(inside.err.find("warning") == std::string::npos);
  const Finished outside =
      run({"model", "predict", "drive-error", "last", "--pose", "10,20,0", "--pose", "120,0,30"});
  CHECK_THAT(outside.err,
             Contains("1 of 2 poses lies outside") && Contains("1 of 2 poses is turned"));
  const Finished beyond =
      run({"model", "predict", "drive-error", "last", "--pose", "0,0,70", "--json"});
  CHECK(beyond.exit_code == 5);
  const OrderedJson answer = OrderedJson::parse(beyond.out);
  CHECK(answer["predictions"][0]["status"] == "other assembly");
  CHECK_FALSE(answer["predictions"][0].contains("x_mm"));
  const Finished table = run({"model", "export", "drive-error", "last", "t.csv", "--step-mm", "60",
                              "--half-width-mm", "120", "--phi-deg", "0,70", "--json"});
  CHECK(table.exit_code == 0);
  const OrderedJson done = OrderedJson::parse(table.out);
  CHECK_THAT(done["words"].dump(), Contains("targets of the table lie outside"));
  CHECK(done["n_unreachable"] >= 20);  // of 50: those turned beyond the singularity
}
