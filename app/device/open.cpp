#include "app/device/open.hpp"

#include <array>

#include "app/device/robot_json.hpp"
#include "app/device/simulated.hpp"
#include "app/exchange/files.hpp"
#include "app/exchange/json_file.hpp"
#include "core/error.hpp"
#include "core/random.hpp"

namespace trammel::device {

namespace {

Devices open_simulated(const std::string& file, const std::string& tracker) {
  if (tracker != "sim") {
    throw UsageError({.what = "a simulated stage is seen by a simulated tracker alone",
                      .where = {.field = "--tracker"},
                      .got = tracker,
                      .expected = "sim"});
  }
  const std::string text = read_file(file, kMaxJsonBytes);
  const std::uint64_t identity = mix(0, text, 0);
  return simulated(simulate::VirtualRobot(parse_robot(text, file)),
                   "robot/1 " + std::to_string(identity));
}

/// One line per kind of stage; what follows the colon is its address.
struct Kind {
  const char* name;
  const char* address;
  Devices (*open)(const std::string& address, const std::string& tracker);
};
constexpr std::array<Kind, 1> kKinds = {{{"sim", "FILE", &open_simulated}}};

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

}  // namespace trammel::device
