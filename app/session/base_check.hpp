#pragma once
// Whether the tracker's base nests are where they were when its frame was registered.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/measure/base_frame.hpp"

namespace trammel::session {

/// The kind of the events that keep what was found, as base_check_json.
inline constexpr const char* kBaseEvent = "base";

struct BaseCheck {
  int after = 0;  // points that were stored then
  std::string nest = {};
  double moved_mm = 0;   // that nest, the one that moved most
  double chance_mm = 0;  // noise leaves moved_mm below, but once in a thousand checks
  double gate_mm = 0;    // more than this, and more than chance: measuring is suspended
  Pose shift = {};       // all nests, as one move in the plane of the base
  bool moved = false;    // beyond chance
  bool off = false;      // beyond chance and gate
};

BaseCheck judged(const BaseDrift& drift, double gate_mm, int after);

/// "base nest B2 has moved 0.0712 mm (chance leaves 0.0610, gate 0.0500)"
std::string words_of(const BaseCheck& check);

/// {"after", "nest", "moved_mm", "chance_mm", "gate_mm", "x_mm", "y_mm", "phi_deg", "moved", "off"}
nlohmann::ordered_json base_check_json(const BaseCheck& check);
/// Nothing for what base_check_json did not write.
std::optional<BaseCheck> read_base_check(const std::string& json);

}  // namespace trammel::session
