#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/files/fields.hpp"
#include "core/plan/check.hpp"
#include "core/plan/plan.hpp"

namespace trammel {

/// {"schema": "trammel/plan/1", "name", "approach_mm", "points": [{"seq", "x_mm", "y_mm",
/// "phi_deg", "set", "approach": [0, 0, 0], "repeat", "reference", "group"}, …]}. Fields that have
/// their default are left out. read_plan gives the same plan back, bit for bit.
nlohmann::ordered_json plan_json(const Plan& plan);

/// Throws InputError with file, line and field; the plan has passed `validate`.
Plan read_plan(const std::filesystem::path& path);

/// A named grid ("paper-80") or a plan's file.
Plan plan_of(const std::string& name_or_file);

/// The field "approach": [1, -1, 0], all 0 where it is absent. Throws InputError.
Approach read_approach(Fields& fields);

/// The field "approaches": [[1, 1, 1], [-1, -1, -1]], one or more. Throws InputError.
std::vector<Approach> read_approaches(Fields& fields);

nlohmann::ordered_json violations_json(const std::vector<Violation>& violations);

}  // namespace trammel
