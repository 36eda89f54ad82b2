#include "app/report/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/job/correction_json.hpp"
#include "app/terminal/lines.hpp"
#include "core/calibrate/simulation.hpp"

namespace trammel::report {

namespace {

using Json = nlohmann::ordered_json;

double distance_mm(const SimulatedError& e) { return std::hypot(e.target.x_mm, e.target.y_mm); }

SimulationRow row_of(const std::vector<SimulatedError>& errors, double from_mm, double to_mm) {
  const SimulationScore score = simulation_score(errors);
  return {.from_mm = from_mm,
          .to_mm = to_mm,
          .n = static_cast<int>(errors.size()),
          .measured_mm = score.measured.mean,
          .simulated_mm = score.simulated.mean,
          .left_mm = score.left.mean};
}

/// A fifth of the way out, rounded up to whole 10 mm.
double ring_width_mm(const std::vector<SimulatedError>& errors) {
  double farthest = 0;
  for (const SimulatedError& e : errors) farthest = std::max(farthest, distance_mm(e));
  return std::max(10.0, 10 * std::ceil(farthest / 50));
}

std::string line(const std::string& label, const SimulationRow& row) {
  return fmt::format("{:<26} {:>4}   {:8.4f}   {:8.4f}   {:8.4f}\n", label, row.n, row.measured_mm,
                     row.simulated_mm, row.left_mm);
}

Json row_json(const SimulationRow& row) {
  return {{"from_mm", row.from_mm},
          {"to_mm", row.to_mm},
          {"n", row.n},
          {"measured_mean_mm", row.measured_mm},
          {"simulated_mean_mm", row.simulated_mm},
          {"left_mean_mm", row.left_mm}};
}

}  // namespace

SimulationTable simulation_table(const Measured& measured, const Comparison& comparison) {
  std::vector<Reading> readings;
  for (const Pair& pair : comparison.paired.pairs) readings.push_back(pair.before->reading);
  const std::vector<SimulatedError> errors = simulated_errors(
      job::correction_of(comparison.job->data.result_json), measured.campaign.machine, readings);
  const double width = ring_width_mm(errors);
  SimulationTable table{.standing = comparison.standing};
  for (double from = 0; from < 5 * width; from += width) {
    std::vector<SimulatedError> ring;
    for (const SimulatedError& e : errors) {
      const double d = distance_mm(e);
      const bool first = from == 0 && d == 0;
      if (first || (d > from && d <= from + width)) ring.push_back(e);
    }
    if (!ring.empty()) table.rings.push_back(row_of(ring, from, from + width));
  }
  table.all = row_of(errors, 0, 5 * width);
  table.left_max_mm = simulation_score(errors).left.max;
  return table;
}

std::string simulation_text(const std::vector<SimulationTable>& tables) {
  if (tables.empty()) return "";
  std::string text = terminal::heading("Forward kinematics simulated with lsq's values");
  text += terminal::wrapped(
      "mean position errors [mm]: as measured before any compensation, as simulated, and of "
      "measured - simulated; by distance of the target from O_A");
  text += fmt::format("{:<26} {:>4}   {:>8}   {:>8}  {:>9}\n", "", "n", "measured", "simulated",
                      "left");
  for (const SimulationTable& table : tables) {
    text += line(fmt::format("{}, all", name_of(table.standing)), table.all);
    for (const SimulationRow& ring : table.rings) {
      text += line(fmt::format("  to {:g} mm", ring.to_mm), ring);
    }
  }
  return text;
}

Json simulation_json(const std::vector<SimulationTable>& tables) {
  Json all = Json::array();
  for (const SimulationTable& table : tables) {
    Json json = {{"in_sample", table.standing == Standing::fitted},
                 {"judged", name_of(table.standing)},
                 {"unit", "mm"},
                 {"n", table.all.n},
                 {"measured_mean_mm", table.all.measured_mm},
                 {"simulated_mean_mm", table.all.simulated_mm},
                 {"left_mean_mm", table.all.left_mm},
                 {"left_max_mm", table.left_max_mm},
                 {"rings", Json::array()}};
    for (const SimulationRow& ring : table.rings) json["rings"].push_back(row_json(ring));
    all.push_back(json);
  }
  return all;
}

}  // namespace trammel::report
