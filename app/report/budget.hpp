#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/judge/budget.hpp"

namespace trammel::report {

/// The budget as a table (GUM 7.2.7): source, distribution, divisor, sensitivity, contribution, and
/// U from all of it. "" without rows.
std::string budget_text(std::span<const BudgetRow> rows);
nlohmann::ordered_json budget_json(std::span<const BudgetRow> rows);

}  // namespace trammel::report
