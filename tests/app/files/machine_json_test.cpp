#include "app/files/machine_json.hpp"

#include "app/files/mechanism_json.hpp"
#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;

namespace {

using MachineText = nlohmann::ordered_json;

Machine read_machine_text(const MachineText& json) {
  const JsonFile file = parse_json(json.dump(1), "m.json");
  return read_machine(Fields(file));
}

/// What is wrong, where and what to do, of a starting machine with one change.
struct BadMachine {
  const char* kind;
  const char* at;  // a JSON pointer
  MachineText value;
  const char* field;
  const char* says;
};

}  // namespace

TEST_CASE("a machine of each kind goes through JSON without losing a bit, under its schema",
          "[exchange]") {
  Random random(31);
  for (const MachineKind& kind : machine_kinds()) {
    CAPTURE(kind.name);
    Machine machine = starting_machine(kind.name);
    for (const MachineParameter& p : parameters_of(kind)) {
      double& value = machine.chains[static_cast<std::size_t>(p.chain)][p.place];
      value += p.is_angle ? rad_from_deg(random.uniform(-0.1, 0.1)) : random.uniform(0, 0.1);
    }
    machine.measured = {true, false, false};
    machine.drives[0].lead_mm = 0.7;
    const MachineText written = machine_json(machine);
    CHECK(tests::schema_errors(nlohmann::json::parse(written.dump()), "machine.schema.json") == "");
    CHECK(read_machine_text(written) == machine);
  }
}

TEST_CASE("files of today's robots are machines too, and a 3-PRR serves where they do",
          "[exchange]") {
  const std::string robot = tests::source_folder() + "/examples/paper/robot.json";
  CHECK(read_machine_file(robot) == starting_machine("3-PRR"));
  const tests::TemporaryFolder folder;
  const auto file = folder.write("m.json", machine_json(starting_machine("3-PRR")).dump());
  CHECK(machine_of(read_mechanism_file(file)) == starting_machine("3-PRR"));
  const auto stage = folder.write("xy.json", machine_json(starting_machine("XY")).dump());
  CHECK_THROWS_WITH(read_mechanism_file(stage), Contains("xy.json") && Contains("3-PRR alone"));
}

TEST_CASE("a machine file that is wrong is refused by field, with what to do", "[exchange]") {
  const MachineText chain = {{"kind", "PPR"}, {"alpha_deg", 0}, {"gamma_deg", 90}};
  const MachineText drive = {{"lead_mm", 1}, {"limits", {{"l_min_mm", 0}, {"l_max_mm", 9}}}};
  const std::vector<BadMachine> cases = {
      {"XY", "/chains/0/S_mm", 430, "chains[0].S_mm", "a parameter of a PRR chain"},
      {"XY", "/chains/0/kind", "PRR", "chains[0].kind", "PPR, as every chain of this XY machine"},
      {"3-PRR", "/chains/1/kind", "RRR", "chains[1].kind", "rotary drives are not served yet"},
      {"XY", "/drives/1/type", "rotary", "drives[1].type", "rotary drives are not served yet"},
      {"XY", "/kind", "3-RRR", "kind", "rotary drives are not served yet"},
      {"XY", "/kind", "delta", "kind", "one of 3-PRR, 3-PPR, 3-RPR, XY, X"},
      {"XY", "/chains/2", chain, "chains", "more than the machine has freedom"},
      {"X", "/drives/1", drive, "drives", "more than the machine has freedom"},
      {"3-PPR", "/drives", MachineText::array({drive}), "drives", "1 drives"},
      {"X", "/measured", {"x", "phi"}, "measured", "phi cannot be measured on an X machine"},
      {"XY", "/measured", {"x", "x"}, "measured", "x is named twice"},
      {"XY", "/measured", {"x", "z"}, "measured", "no such coordinate: z"},
      {"XY", "/measured", MachineText::array(), "measured", "no coordinate is measured"},
      {"XY", "/home/phi_deg", 0, "home.phi_deg", "phi is no coordinate of an XY machine"},
      {"XY", "/home", {{"x_mm", 1}}, "home.y_mm", "is missing"},
      {"XY", "/chains/0/r_mm", 5, "chains[0].r_mm", "is a point"},
      {"3-PPR", "/chains/2/gamma_deg", 90, "chains[2]",
       "the passive guide lies along its own drive"},
      {"3-PPR", "/chains/2/gamma_deg", -90, "chains[2]", "along its own drive"},
      {"3-RPR", "/chains/0/r_mm", 0, "chains[0].r_mm", "a positive length"},
      {"3-RPR", "/home/phi_deg", -60, "home", "singular at home"},
      {"3-PRR", "/home/phi_deg", 60, "home", "singular at home"},
      {"XY", "/drives/0/limits/l_max_mm", -200, "drives[0].limits.l_max_mm", "more than l_min_mm"},
      {"XY", "/drives/0/lead_mm", 0, "drives[0].lead_mm", "a positive length"},
      {"XY", "/chains/0/alfa_deg", 0, "chains[0].alfa_deg", "alfa_deg"},
  };
  for (const BadMachine& c : cases) {
    CAPTURE(c.kind, c.at, c.value.dump());
    MachineText written = machine_json(starting_machine(c.kind));
    written[MachineText::json_pointer(c.at)] = c.value;
    try {
      static_cast<void>(read_machine_text(written));
      FAIL_CHECK("was not refused");
    } catch (const InputError& error) {
      CHECK(error.text().where.field == c.field);
      CHECK(error.text().where.file == "m.json");
      CHECK(error.text().where.line > 0);
      CHECK_THAT(describe(error.text()), Contains(c.says));
    }
  }
  // Where the platform is turned against its base it is fit for use; so is a skewed guide.
  MachineText skewed = machine_json(starting_machine("3-PPR"));
  skewed["chains"][2]["gamma_deg"] = 89;
  CHECK_NOTHROW(read_machine_text(skewed));
}
