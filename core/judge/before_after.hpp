#pragma once
// Errors of the same points before and after a correction, in the figures that everybody prints.

#include <optional>
#include <span>
#include <vector>

#include "core/mechanism/machine.hpp"
#include "core/mechanism/pose.hpp"
#include "core/statistics/summary.hpp"

namespace trammel {

/// One point: where it should be, where it was, and where it is (or would be) after.
struct BeforeAfter {
  Pose target;
  Pose before;
  Pose after;
};

enum class Figure { position_mm, attitude_deg };

/// Position, and attitude where it is measured.
std::vector<Figure> figures_of(const Machine& machine);

/// How far a pose is from its target, in the unit of the figure.
double error_in(Figure figure, const Pose& pose, const Pose& target);

/// Errors point by point, their summaries, and 100 (1 - mean after / mean before).
struct Errors {
  std::vector<double> before, after;
  Summary summary_before = {}, summary_after = {};
  std::optional<double> improvement_pct = {};
};
/// Throws InputError where there is no point. Proof: before_after_test.cpp.
Errors errors_in(Figure figure, std::span<const BeforeAfter> points);

/// U (k = 2) of one corrected point: of a coordinate of place, and of phi.
struct Expanded {
  double U_mm = 0;
  double U_rad = 0;
};

}  // namespace trammel
