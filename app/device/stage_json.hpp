#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "app/device/galil_settings.hpp"

namespace trammel::device {

/// A stage as its file tells it.
struct StageFile {
  GalilSettings galil;
  bool emulated = false;  // what answers is a program: its campaigns are simulated ones
};

/// "format": "stage/1" with "controller" {type "galil", host, port, timeouts}, "mechanism" (a
/// machine/1, or a 3-PRR as in campaign/1), an axis for each of its drives in "axes" {axis,
/// lead_mm, counts_per_rev, gear, sign, zero_mm}, and, all optional, "motion", "homing" and
/// "emulated". lead_mm is that of the machine's drive where it is absent, zero_mm the displacement
/// of the home pose. Throws InputError with file, line and field; the settings have passed
/// `validate`. Proof: stage_json_test.cpp.
StageFile read_stage(const std::filesystem::path& path);

/// The same from text; `name` stands in errors.
StageFile parse_stage(std::string_view text, const std::string& name);

}  // namespace trammel::device
