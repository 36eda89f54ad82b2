#include "app/session/base_check.hpp"

#include <fmt/format.h>

#include "core/units.hpp"

namespace trammel::session {

BaseCheck judged(const BaseDrift& drift, double gate_mm, int after) {
  return {.after = after,
          .nest = drift.nest,
          .moved_mm = drift.largest_mm,
          .chance_mm = drift.limit_mm,
          .gate_mm = gate_mm,
          .shift = drift.shift,
          .moved = drift.moved,
          .off = drift.moved && !(drift.largest_mm <= gate_mm)};
}

std::string words_of(const BaseCheck& check) {
  return fmt::format("base nest {} has moved {:.4f} mm (chance leaves {:.4f}, gate {:.4f})",
                     check.nest, check.moved_mm, check.chance_mm, check.gate_mm);
}

nlohmann::ordered_json base_check_json(const BaseCheck& check) {
  return {{"after", check.after},       {"nest", check.nest},
          {"moved_mm", check.moved_mm}, {"chance_mm", check.chance_mm},
          {"gate_mm", check.gate_mm},   {"x_mm", check.shift.x_mm},
          {"y_mm", check.shift.y_mm},   {"phi_deg", deg_from_rad(check.shift.phi_rad)},
          {"moved", check.moved},       {"off", check.off}};
}

std::optional<BaseCheck> read_base_check(const std::string& text) {
  try {
    const auto json = nlohmann::json::parse(text);
    const auto number = [&json](const char* key) { return json.at(key).get<double>(); };
    return BaseCheck{.after = json.at("after").get<int>(),
                     .nest = json.at("nest").get<std::string>(),
                     .moved_mm = number("moved_mm"),
                     .chance_mm = number("chance_mm"),
                     .gate_mm = number("gate_mm"),
                     .shift = {number("x_mm"), number("y_mm"), rad_from_deg(number("phi_deg"))},
                     .moved = json.at("moved").get<bool>(),
                     .off = json.at("off").get<bool>()};
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace trammel::session
