#include <algorithm>
#include <array>

#include "app/report/report.hpp"

namespace trammel::report {

namespace {

struct Row {
  const char* id;
  const char* table;
  std::array<double, 3> before, after;  // mean, max, min; mm or deg
};

constexpr std::array<Row, 6> kRows = {{
    {"lsq-80-position", "IV", {0.2115, 0.6103, 0.0141}, {0.0241, 0.0583, 0.0000}},
    {"lsq-80-attitude", "V", {0.0859, 0.1892, 0.0145}, {0.0501, 0.0877, 0.0002}},
    {"idw-48-position", "VI", {0.3607, 0.8022, 0.0922}, {0.1473, 0.4373, 0.0000}},
    {"idw-48-attitude", "VII", {0.0727, 0.1607, 0.0114}, {0.0429, 0.1435, 0.0000}},
    {"rbf-48-position", "IX", {0.1677, 0.3701, 0.0583}, {0.0619, 0.1300, 0.0200}},
    {"rbf-48-attitude", "X", {0.0727, 0.1607, 0.0114}, {0.0389, 0.0850, 0.0000}},
}};

struct Parameter {
  const char* name;
  double value;  // mm or deg
};
/// Table III; what is blank there is absent here.
constexpr std::array<Parameter, 11> kTableIII = {{{"alpha_1", 0.0094},
                                                  {"alpha_2", 0.0050},
                                                  {"alpha_3", 0.0030},
                                                  {"beta_1", 0.0073},
                                                  {"beta_2", -0.0018},
                                                  {"l_1", -0.2635},
                                                  {"l_2", 0.3707},
                                                  {"l_3", -0.2933},
                                                  {"S_1", 0.0041},
                                                  {"S_3", 0.0187},
                                                  {"r_3", 0.0054}}};

}  // namespace

std::optional<double> paper_parameter(const std::string& name) {
  for (const Parameter& p : kTableIII) {
    if (name == p.name) return p.value;
  }
  return std::nullopt;
}

std::optional<PaperFigures> paper_figures(const std::string& id) {
  const auto* row =
      std::find_if(kRows.begin(), kRows.end(), [&id](const Row& r) { return r.id == id; });
  if (row == kRows.end()) return std::nullopt;
  return PaperFigures{.table = row->table,
                      .in_sample = id.starts_with("lsq"),
                      .before_mean = row->before[0],
                      .before_max = row->before[1],
                      .before_min = row->before[2],
                      .after_mean = row->after[0],
                      .after_max = row->after[1],
                      .after_min = row->after[2]};
}

}  // namespace trammel::report
