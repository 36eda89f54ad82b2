#pragma once

#include <nlohmann/json.hpp>

#include "app/files/fields.hpp"
#include "core/mechanism/geometry.hpp"

namespace trammel {

/// The "mechanism" object of campaign/1: {type, screw_lead_mm, home, limits, chains[3]}, a chain
/// {alpha_deg, beta_deg, r_mm, S_mm, R_mm} and, optional, h_mm and l_zero_mm. `home` defaults to
/// the origin, the limits to 0..600 mm. Throws InputError naming file, line and field; the
/// mechanism has passed `validate`.
Mechanism read_mechanism(Fields mechanism);

/// The same object; read_mechanism gives the same numbers back, bit for bit.
nlohmann::ordered_json mechanism_json(const Mechanism& mechanism);

/// {x_mm, y_mm, phi_deg}
Pose read_pose(Fields pose);
nlohmann::ordered_json pose_json(const Pose& pose);

/// A file that holds a mechanism: the object itself, or any object with a "mechanism" field (a
/// campaign.json, a robot.json).
Mechanism read_mechanism_file(const std::filesystem::path& path);

}  // namespace trammel
