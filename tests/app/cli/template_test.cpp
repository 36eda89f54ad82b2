// Every template is read by the reader that its users' files go through.

#include "app/cli/template.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "app/device/stage_json.hpp"
#include "app/device/tracker_json.hpp"
#include "app/files/campaign_file.hpp"
#include "app/files/layout.hpp"
#include "app/files/machine_json.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/plan_json.hpp"
#include "app/files/robot_json.hpp"
#include "app/protocol/protocol.hpp"
#include "core/plan/check.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::run_here;

TEST_CASE("every template is valid as it is, and explains itself", "[cli]") {
  const tests::TemporaryFolder folder;
  const std::filesystem::path at = folder.path();
  const auto write = [&at](const cli::TemplateFile& file, const std::string& name) {
    write_output(at / name, file.text, Existing::replace);
    return at / name;
  };
  const auto starts_as = [](const char* kind, const std::filesystem::path& path) {
    const Machine read = read_machine_file(path), expected = starting_machine(kind);
    REQUIRE(read.kind == expected.kind);
    CHECK((read.drives == expected.drives && read.home == expected.home));
    CHECK(read.measured == expected.measured);
    for (const MachineParameter& p : parameters_of(*read.kind)) {
      CAPTURE(p.name);
      const auto i = static_cast<std::size_t>(p.chain);
      const double off = read.chains[i][p.place] - expected.chains[i][p.place];
      CHECK_THAT(p.is_angle ? std::remainder(off, 2 * kPi) : off, WithinAbs(0, 1e-6));
    }
  };
  const std::map<std::string_view, std::function<void(const std::filesystem::path&)>> readers = {
      {"machine.3-prr.json", [](const auto& path) { (void)read_mechanism_file(path); }},
      {"machine.3-ppr.json", [&](const auto& path) { starts_as("3-PPR", path); }},
      {"machine.3-rpr.json", [&](const auto& path) { starts_as("3-RPR", path); }},
      {"machine.xy.json", [&](const auto& path) { starts_as("XY", path); }},
      {"machine.x.json", [&](const auto& path) { starts_as("X", path); }},
      {"layout.json", [](const auto& path) { (void)read_layout(path); }},
      {"stage.galil.json", [](const auto& path) { (void)device::read_stage(path); }},
      {"tracker.t2sa.json", [](const auto& path) { (void)device::read_tracker(path); }},
      {"tracker.file.json", [](const auto& path) { (void)device::read_tracker(path); }}};
  int n_campaign = 0;
  for (const cli::TemplateFile& file : cli::template_files()) {
    CAPTURE(std::string(file.name));
    if (file.name.starts_with("campaign.")) {  // two files that are read together
      write(file, file.name == "campaign.json" ? "campaign.json" : "readings.csv");
      ++n_campaign;
      continue;
    }
    CHECK(file.text.starts_with("// "));
    const std::filesystem::path path = write(file, std::string(file.name));
    const std::string noun(file.name.substr(0, file.name.find('.')));
    if (noun == "robot") {
      (void)read_robot(path);
    } else if (noun == "protocol") {
      (void)protocol::read_protocol(path);
    } else if (noun == "plan") {  // safe on the machine of its kind
      const std::string kind(file.name.substr(5));
      CHECK(check(read_plan(path), read_machine_file(at / ("machine." + kind))).empty());
    } else {
      REQUIRE(readers.count(file.name) == 1);
      readers.at(file.name)(path);
    }
  }
  REQUIRE(n_campaign == 2);
  CHECK(read_campaign(at).campaign.readings.size() == 5);
}

TEST_CASE("from templates alone a machine of each kind is checked, measured and judged as promised",
          "[cli][release]") {
  for (const std::string kind : {"3-prr", "3-ppr", "3-rpr", "xy", "x"}) {
    CAPTURE(kind);
    const tests::TemporaryFolder folder;
    const auto run = [&folder](const std::vector<std::string>& words) {
      CAPTURE(words);
      const auto done = run_here(words, folder.path());
      CAPTURE(done.out, done.err);
      REQUIRE(done.exit_code == 0);
      return done;
    };
    for (const std::string noun : {"machine", "robot", "plan", "protocol"}) {
      run({"template", noun, kind, "--out", noun + ".json"});
    }
    run({"mechanism", "check", "machine.json"});
    run({"plan", "check", "plan.json", "--mechanism", "machine.json"});
    run({"protocol", "check", "protocol.json"});
    run({"protocol", "run", "protocol.json", "--confirm", "ready"});
    const auto report = nlohmann::json::parse(run({"report", "my-campaign", "--json"}).out);
    int n_judged = 0;
    for (const auto& t : report.at("tables")) {
      if (t.at("judged") != "held-out" || t.at("figure") != "position") continue;
      n_judged += t.at("before").at("n").get<int>();
      CHECK(t.at("after").at("mean").get<double>() < t.at("before").at("mean").get<double>());
    }
    const std::string about = protocol::read_protocol(folder.path() / "protocol.json").about;
    CHECK_THAT(about, Contains(std::to_string(n_judged) + " others to judge"));
  }
}

TEST_CASE("a template goes where --out says, and the line to use it comes with it", "[cli]") {
  const tests::TemporaryFolder folder;
  const auto printed = run_here({"template", "stage", "galil"}, folder.path());
  CHECK(printed.exit_code == 0);
  const auto written = run_here({"template", "stage", "--out", "-my stage.json"}, folder.path());
  CHECK(written.exit_code == 0);
  CHECK(written.out.empty());
  CHECK_THAT(written.err, Contains("--stage galil:'-my stage.json'"));
  CHECK(read_file(folder.path() / "-my stage.json", 1 << 20) == printed.out);
  const auto wrong = run_here({"template", "tracker", "galil"}, folder.path());
  CHECK(wrong.exit_code == 2);
  CHECK_THAT(wrong.err, Contains("t2sa, file"));
}

TEST_CASE(
    "a file that does not say what it is, or says another, is refused with the formats there are",
    "[cli]") {
  const tests::TemporaryFolder folder;
  for (const char* text : {"{}", R"({"format": "robot/1"})", R"({"format": 3})"}) {
    CAPTURE(text);
    folder.write("a.json", text);
    try {
      (void)read_layout(folder.path() / "a.json");
      FAIL("was taken");
    } catch (const InputError& error) {
      CHECK(error.text().where.field == "format");
      for (const char* format :
           {"layout/1", "campaign/2", "machine/1", "tracker/1", "trammel/plan/1"}) {
        CHECK_THAT(error.text().expected, Contains(format));
      }
      CHECK_THAT(error.text().hint, Contains("trammel template"));
    }
  }
  folder.write("b.json", "{}");
  CHECK_THAT(run_here({"mechanism", "check", "b.json"}, folder.path()).err, Contains("machine/1"));
}
