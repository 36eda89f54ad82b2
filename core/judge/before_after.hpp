#pragma once
// Errors of the same points before and after a correction, in the figures that everybody prints.

#include <optional>
#include <span>
#include <vector>

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

/// U (k = 2) of one corrected point: of a coordinate of place in its worst direction, and of phi.
struct Expanded {
  double U_mm = 0;
  double U_rad = 0;
};

/// U of a coordinate from the lengths of held-out position errors: twice their root mean square,
///   U = 2 sqrt(sum |e|^2 / (2 n)),   the same at every point, noise of the readings included
double coordinate_U_mm(std::span<const double> position_mm);

/// The same from held-out errors (measured less target, after), and of phi 2 sqrt(sum e_phi^2 / n).
/// Precondition, of both: some errors. Proof: before_after_test.cpp.
Expanded expanded_from(std::span<const Pose> errors);

}  // namespace trammel
