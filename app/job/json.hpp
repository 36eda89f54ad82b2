#pragma once
// JSON of jobs: fields keep their order, a number that may be missing is null.

#include <nlohmann/json.hpp>
#include <optional>

namespace trammel::job {

using Json = nlohmann::ordered_json;

inline Json optional_json(const auto& value) { return value ? Json(*value) : Json(nullptr); }

/// The number named `name`; none when it is missing or null.
inline std::optional<double> optional_number(const Json& json, const char* name) {
  return json.contains(name) && json[name].is_number()
             ? std::optional<double>(json[name].get<double>())
             : std::nullopt;
}

}  // namespace trammel::job
