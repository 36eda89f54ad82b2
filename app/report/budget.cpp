#include "app/report/budget.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/terminal/decimals.hpp"

namespace trammel::report {

std::string budget_text(std::span<const BudgetRow> rows) {
  if (rows.empty()) return "";
  const int decimals = terminal::decimals_of(2 * combined_mm(rows));
  std::string text = fmt::format("    {:<12}{:>9} {:<3}{:>8}{:>13}{:>10}  {}\n", "budget", "value",
                                 "", "divisor", "sensitivity", "u [mm]", "source");
  for (const BudgetRow& r : rows) {
    text += fmt::format("    {:<12}{:>9.4g} {:<3}{:>8.3f}{:>13.5g}{:>10.{}f}  {}, {}{}\n", r.name,
                        r.value, r.unit, r.divisor, r.sensitivity, r.contribution_mm(),
                        decimals + 1, r.distribution, r.source,
                        r.cancels ? "; cancels between before and after" : "");
  }
  const bool unknown = std::ranges::any_of(
      rows, [](const BudgetRow& r) { return r.source.find("not known") != std::string::npos; });
  return text + fmt::format("    {:<45}{:>10.{}f}  U = {:.{}f} mm (k = 2) of a coordinate{}\n",
                            "combined", combined_mm(rows), decimals + 1, 2 * combined_mm(rows),
                            decimals, unknown ? ", without the instrument" : "");
}

nlohmann::ordered_json budget_json(std::span<const BudgetRow> rows) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const BudgetRow& r : rows) {
    all.push_back({{"name", r.name},
                   {"source", r.source},
                   {"distribution", r.distribution},
                   {"value", r.value},
                   {"unit", r.unit},
                   {"divisor", r.divisor},
                   {"sensitivity", r.sensitivity},
                   {"u_mm", r.contribution_mm()},
                   {"cancels", r.cancels}});
  }
  return {{"rows", all}, {"u_mm", combined_mm(rows)}, {"U_k2_mm", 2 * combined_mm(rows)}};
}

}  // namespace trammel::report
