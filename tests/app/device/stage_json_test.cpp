#include "app/device/stage_json.hpp"

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

using StageJson = nlohmann::json;

std::string stage_text() {
  return tests::read_text(tests::source_folder() + "/examples/stage/galil.json");
}

/// The example with the value at `pointer` replaced.
std::string stage_with(const std::string& pointer, const StageJson& value) {
  StageJson json = StageJson::parse(stage_text());
  json[StageJson::json_pointer(pointer)] = value;
  return json.dump(1);
}

ErrorText stage_error(const std::string& text) {
  try {
    static_cast<void>(parse_stage(text, "stage.json"));
  } catch (const InputError& error) {
    return error.text();
  }
  FAIL("the file was taken");
  return {};
}

}  // namespace

TEST_CASE("the example of a stage is read as it stands, and valid", "[device][galil]") {
  const StageFile stage = parse_stage(stage_text(), "galil.json");
  CHECK_FALSE(stage.emulated);
  CHECK(stage.galil.controller.text() == "192.168.1.10:23");
  CHECK(stage.galil.axes[1].letter == 'B');
  CHECK(stage.galil.axes[2].lead_mm == 10);
  CHECK(stage.galil.axes[0].zero_mm == Approx(261.811206).margin(1e-6));  // the home pose's
  CHECK(stage.galil.settle_s == 0.5);
  CHECK(tests::schema_errors(StageJson::parse(stage_text()), "stage.schema.json") == "");
}

TEST_CASE("what a stage cannot do is refused with its line before anything moves",
          "[device][galil]") {
  struct Case {
    const char* pointer;
    StageJson value;
    const char* field;
    bool by_schema;
  };
  for (const Case& c : {Case{"/controller/port", 0, "controller.port", true},
                        {"/controller/type", "acs", "controller.type", true},
                        {"/axes/1/axis", "A", "axes[1].axis", false},
                        {"/axes/1/axis", "Z", "axes[1].axis", true},
                        {"/axes/0/counts_per_rev", 1e9, "axes[0].counts_per_rev", false},
                        {"/axes/0/sign", 0, "axes[0].sign", true},
                        {"/axes/2/gear", -1, "axes[2].gear", true},
                        {"/axes/0/zero_mm", 900, "axes[0].zero_mm", false},
                        {"/motion/speed_mm_s", 1e5, "motion.speed_mm_s", false},
                        {"/motion/speed_mm_s", 1e-4, "motion.speed_mm_s", false},
                        {"/motion/acceleration_mm_s2", 2e6, "motion.acceleration_mm_s2", false},
                        {"/motion/settle_band_mm", 0.001, "motion.settle_band_mm", false},
                        {"/motion/following_mm", 0.004, "motion.following_mm", false},
                        {"/motion/following_mm", 1e300, "motion.following_mm", false},
                        {"/motion/settle_timeout_s", 0.1, "motion.settle_timeout_s", false},
                        {"/controller/reply_timeout_s", -1, "controller.reply_timeout_s", true},
                        {"/controller/watch_host_s", 0.05, "controller.watch_host_s", false},
                        {"/controller/watch_host_s", 100, "controller.watch_host_s", true},
                        {"/homing/speed_mm_s", 0, "homing.speed_mm_s", true},
                        {"/mechanism/chains/1/S_mm", -1, "mechanism.chains[1].S_mm", true},
                        {"/motion/speed", 1, "motion.speed", true}}) {
    CAPTURE(c.pointer, c.value.dump());
    const std::string text = stage_with(c.pointer, c.value);
    const ErrorText error = stage_error(text);
    CHECK(error.where.file == "stage.json");
    CHECK(error.where.line > 0);
    CHECK(error.where.field == c.field);
    CHECK((tests::schema_errors(StageJson::parse(text), "stage.schema.json") != "") == c.by_schema);
  }
}
