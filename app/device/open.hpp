#pragma once

#include <string>
#include <vector>

#include "app/device/device.hpp"

namespace trammel::device {

/// The devices that `--stage` and `--tracker` name: "sim:FILE" and "sim", or "galil:FILE" and
/// "t2sa:FILE" or "file:FILE". No real device is spoken to before it is used. Throws UsageError for
/// a kind of device that does not exist, listing those that do; InputError for a file of no robot.
Devices open_devices(const std::string& stage, const std::string& tracker);

/// How a stage's name begins, by kind: "sim:".
std::vector<std::string> stage_kinds();

/// The same of trackers that see a real stage: "t2sa:", "file:".
std::vector<std::string> tracker_kinds();

}  // namespace trammel::device
