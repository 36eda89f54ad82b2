#pragma once

#include <filesystem>

#include "core/simulate/truth.hpp"

namespace trammel {

/// The hidden truth of a virtual robot, "format": "robot/1": the nominal "mechanism" (a
/// 3-PRR as in campaign/1, or a machine/1), then, all optional, "geometry_errors" (as many chains,
/// added to the nominal ones),
/// "zeroed_at_home", "phi_zero_deg", "drive", "bumps", "harmonics", "shifts", "epochs", "tracker",
/// "temperature", "motion", "seed". The fields are those of core/simulate/truth.hpp, angles in deg,
/// rails numbered from 1. Throws InputError with file, line and field.
simulate::Truth read_robot(const std::filesystem::path& path);

/// The same from text; `name` stands in errors.
simulate::Truth parse_robot(std::string_view text, const std::string& name);

}  // namespace trammel
