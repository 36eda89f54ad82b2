#include "app/device/open.hpp"

#include <array>

#include "app/device/clock.hpp"
#include "app/device/galil.hpp"
#include "app/device/simulated.hpp"
#include "app/device/stage_json.hpp"
#include "app/device/tracker_json.hpp"
#include "app/files/files.hpp"
#include "app/files/json_file.hpp"
#include "app/files/robot_json.hpp"
#include "core/error.hpp"
#include "core/statistics/random.hpp"

namespace trammel::device {

namespace {

std::string hashed(const std::string& text) { return std::to_string(mix(0, text, 0)); }

Devices open_simulated(const std::string& file, const std::string& tracker) {
  if (tracker != "sim") {
    throw UsageError({.what = "a simulated stage needs a simulated tracker",
                      .where = {.field = "--tracker"},
                      .got = tracker,
                      .expected = "sim"});
  }
  const std::string text = read_file(file, kMaxJsonBytes);
  return simulated(simulate::VirtualRobot(parse_robot(text, file)), "robot/1 " + hashed(text));
}

/// "t2sa:FILE", "file:FILE": the file says the same.
TrackerFile open_tracker(const std::string& tracker, const std::string& text,
                         const std::string& file) {
  TrackerFile opened = parse_tracker(text, file);
  const std::string kind = tracker.substr(0, tracker.find(':'));
  if (opened.kind != kind) {
    throw UsageError({.what = "the file is of another kind of tracker",
                      .where = {.field = "--tracker"},
                      .got = tracker,
                      .expected = opened.kind + ":" + file});
  }
  return opened;
}

std::string file_of_tracker(const std::string& tracker) {
  for (const std::string& kind : tracker_kinds()) {
    if (tracker.starts_with(kind)) return tracker.substr(kind.size());
  }
  throw UsageError({.what = "a real stage needs a real tracker",
                    .where = {.field = "--tracker"},
                    .got = tracker,
                    .expected = "t2sa:FILE, file:FILE"});
}

Devices open_galil(const std::string& file, const std::string& tracker_option) {
  const std::string tracker_file = file_of_tracker(tracker_option);
  const std::string text = read_file(file, kMaxJsonBytes);
  const std::string tracker_text = read_file(tracker_file, kMaxJsonBytes);
  StageFile stage = parse_stage(text, file);
  TrackerFile tracker = open_tracker(tracker_option, tracker_text, tracker_file);
  if (stage.emulated != tracker.emulated) {
    throw InputError({.what = "one of stage and tracker is emulated, the other real",
                      .where = {.file = tracker_file, .field = "emulated"},
                      .got = tracker.emulated ? "true" : "false",
                      .expected = stage.emulated ? "true" : "false",
                      .hint = "readings of the two are never mixed"});
  }
  Devices devices;
  devices.simulated = stage.emulated;
  devices.identity = "stage/1 " + hashed(text) + ", tracker/1 " + hashed(tracker_text);
  devices.machine = stage.galil.machine;
  devices.motion.speed_mm_s = stage.galil.speed_mm_s;
  devices.motion.following_mm = stage.galil.following_mm;
  devices.controller = stage.galil.controller.text();
  devices.watch_host_s = stage.galil.watch_host_s;
  devices.sigma = tracker.sigma;
  devices.clock = real_clock({.machine = stage.galil.machine,
                              .speed_mm_s = stage.galil.speed_mm_s,
                              .acceleration_mm_s2 = stage.galil.acceleration_mm_s2,
                              .settle_s = stage.galil.settle_s,
                              .measure_s = tracker.measure_s});
  devices.stage = std::make_unique<GalilStage>(std::move(stage.galil));
  devices.tracker = std::move(tracker.tracker);
  devices.thermometer = std::move(tracker.thermometer);
  return devices;
}

/// One line per kind of stage; what follows the colon is its address.
struct Kind {
  const char* name;
  const char* address;
  Devices (*open)(const std::string& address, const std::string& tracker);
};
constexpr std::array<Kind, 2> kKinds = {
    {{"sim", "FILE", &open_simulated}, {"galil", "FILE", &open_galil}}};

}  // namespace

Devices open_devices(const std::string& stage, const std::string& tracker) {
  const std::size_t colon = stage.find(':');
  std::string known;
  for (const Kind& kind : kKinds) {
    if (colon != std::string::npos && stage.substr(0, colon) == kind.name) {
      return kind.open(stage.substr(colon + 1), tracker);
    }
    known += (known.empty() ? "" : ", ") + std::string(kind.name) + ":" + kind.address;
  }
  throw UsageError({.what = "no such kind of stage",
                    .where = {.field = "--stage"},
                    .got = stage,
                    .expected = known});
}

std::vector<std::string> tracker_kinds() { return {"t2sa:", "file:"}; }

std::vector<std::string> stage_kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.push_back(kind.name + std::string(":"));
  return names;
}

}  // namespace trammel::device
