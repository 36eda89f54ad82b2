#include "app/device/tracker_json.hpp"

#include <nlohmann/json.hpp>

#include "app/device/open.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

using TrackerJson = nlohmann::json;

const std::string kExamples = tests::source_folder() + "/examples/stage/";

TrackerJson tracker_example(const char* name) {
  return TrackerJson::parse(tests::read_text(kExamples + name));
}

ErrorText tracker_error(const TrackerJson& json) {
  try {
    static_cast<void>(parse_tracker(json.dump(1), "tracker.json"));
  } catch (const InputError& error) {
    return error.text();
  }
  FAIL("the file was taken");
  return {};
}

}  // namespace

TEST_CASE("the examples of trackers are read as they stand, and valid", "[device][tracker]") {
  const TrackerFile t2sa = read_tracker(kExamples + "t2sa.json");
  CHECK(t2sa.kind == "t2sa");
  CHECK(t2sa.tracker->describe() == "laser tracker behind T2SA at 192.168.1.20:50000");
  // About their centroid, the origin: sigma / sqrt(sum r^2), r^2 = 8200 + 8900 + 6500 mm^2.
  CHECK(t2sa.sigma.phi_rad == Approx(0.005 / std::sqrt(23600.0)).epsilon(1e-4));
  CHECK(t2sa.sigma.xy_mm == Approx(0.005 / std::sqrt(3.0)).epsilon(1e-4));
  const TrackerFile file = read_tracker(kExamples + "tracker_file.json");
  CHECK(file.kind == "file");
  CHECK(file.thermometer->describe().find("weather record") == 0);
  for (const char* name : {"t2sa.json", "t2sa_object.json", "tracker_file.json"}) {
    CAPTURE(name);
    CHECK_NOTHROW(read_tracker(kExamples + name));
    CHECK(tests::schema_errors(tracker_example(name), "tracker.schema.json") == "");
  }
}

TEST_CASE("what is no tracker is refused with its line", "[device][tracker]") {
  struct Case {
    const char* example;
    const char* pointer;
    TrackerJson value;
    const char* field;
  };
  for (const Case& c : {Case{"t2sa.json", "/source/type", "lmf", "source.type"},
                        {"t2sa.json", "/source/port", 70000, "source.port"},
                        {"t2sa.json", "/source/reply_timeout_s", 0, "source.reply_timeout_s"},
                        {"t2sa.json", "/nests/1/point", "A;platform", "nests[1].point"},
                        {"t2sa.json", "/nests/1/point", "A;platform;P2\r\n!HALT", "nests[1].point"},
                        {"t2sa.json", "/nests", TrackerJson::array(), "nests"},
                        {"t2sa.json", "/sigma_mm", 0, "sigma_mm"},
                        {"t2sa.json", "/base_frame", {{"x_mm", 0}, {"y_mm", 0}}, "base_nests"},
                        {"t2sa.json", "/temperature/source", "tracker", "temperature.source"},
                        {"t2sa_object.json", "/object/sigma_phi_deg", 0, "object.sigma_xy_mm"},
                        {"tracker_file.json", "/source/format", "f9", "source.format"},
                        {"tracker_file.json", "/source/unit", "furlong", "source.unit"},
                        {"tracker_file.json", "/source/rows", "as they come", "source.rows"},
                        {"tracker_file.json", "/color", "red", "color"}}) {
    CAPTURE(c.example, c.pointer, c.value.dump());
    TrackerJson json = tracker_example(c.example);
    json[TrackerJson::json_pointer(c.pointer)] = c.value;
    const ErrorText error = tracker_error(json);
    CHECK(error.where.file == "tracker.json");
    CHECK(error.where.line > 0);
    CHECK(error.where.field == c.field);
  }
}

TEST_CASE("one nest gives no orientation, and the file that asks for it is told so",
          "[device][tracker]") {
  TrackerJson json = tracker_example("t2sa.json");
  json["nests"].erase(2);
  CHECK_NOTHROW(parse_tracker(json.dump(), "tracker.json"));
  json["nests"].erase(1);
  CHECK_THAT(tracker_error(json).what, Catch::Matchers::Contains("not how it is turned"));
  json = tracker_example("t2sa.json");
  json["nests"][1]["x_mm"] = json["nests"][0]["x_mm"];
  json["nests"][1]["y_mm"] = json["nests"][0]["y_mm"];
  json["nests"].erase(2);
  CHECK_THAT(tracker_error(json).what, Catch::Matchers::Contains("give no pose"));
}

TEST_CASE("a triangle of nests with equal sides is refused, but for a stated reason",
          "[device][tracker]") {
  TrackerJson json = tracker_example("t2sa.json");
  json["nests"][0]["x_mm"] = -10;  // as far from P2 as from P3
  json["nests"][0]["y_mm"] = 30;
  CHECK_THAT(tracker_error(json).what, Catch::Matchers::Contains("equal sides"));
  CHECK(tracker_error(json).where.field == "nests");
  json["nests"][0]["y_mm"] = 30.1;  // 0.009 mm apart, six sigma are 0.042 mm
  CHECK_THAT(tracker_error(json).what, Catch::Matchers::Contains("equal sides"));
  TrackerJson told = json;
  told["symmetric_because"] = "the platform has been drilled so";
  CHECK_NOTHROW(parse_tracker(told.dump(), "tracker.json"));
  CHECK(tests::schema_errors(told, "tracker.schema.json") == "");
  json["nests"][0]["y_mm"] = 32;  // the control
  CHECK_NOTHROW(parse_tracker(json.dump(), "tracker.json"));
}

TEST_CASE("a real stage and a real tracker are opened without a word to either",
          "[device][tracker]") {
  const Devices devices =
      open_devices("galil:" + kExamples + "galil.json", "t2sa:" + kExamples + "t2sa.json");
  CHECK_FALSE(devices.simulated);
  CHECK(devices.stage->describe() == "Galil DMC-41x3 at 192.168.1.10:23");
  CHECK_FALSE(devices.stage->homed());
  CHECK(devices.sigma.has_value());
  CHECK(devices.identity !=
        open_devices("galil:" + kExamples + "galil.json", "t2sa:" + kExamples + "t2sa_object.json")
            .identity);
}

TEST_CASE("stage and tracker that do not go together are refused", "[device][tracker]") {
  const std::string galil = "galil:" + kExamples + "galil.json";
  CHECK_THROWS_AS(open_devices(galil, "sim"), UsageError);
  CHECK_THROWS_AS(open_devices(galil, "file:" + kExamples + "t2sa.json"), UsageError);
  CHECK_THROWS_AS(open_devices("acs:x", "sim"), UsageError);
  const tests::TemporaryFolder folder;
  TrackerJson json = tracker_example("t2sa.json");
  json["emulated"] = true;
  const auto emulated = folder.write("t.json", json.dump());
  CHECK_THROWS_AS(open_devices(galil, "t2sa:" + emulated.string()), InputError);
}
