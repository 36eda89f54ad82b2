#pragma once
// Single readings that are wrong for certain, whatever the model: no good neighbour.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/measure/screen.hpp"

namespace trammel {

/// Readings that repeat the pose of the one before although they were asked for another (stale),
/// that are 0, 0, 0 (missed), whose command no correction asks for, or whose deviation from the
/// target lies far from what the others have about that place (far). For the last a smooth field,
/// cubic in x and y and with phi where it varies, is fitted to the deviations of each epoch's
/// readings, by least absolute deviations first, then by least squares without those beyond
/// kFarTimes of the robust scale of what is left, until they are the same; a reading is far when a
/// coordinate stays beyond kFarTimes of that scale: geometry, effects and directions widen it.
/// Where what lies near has heavy tails itself (Student's t of 3 degrees passes 25 scales once in
/// 13,000 times a coordinate) it is far beyond some 60. What a calibration's own residuals name
/// lies nearer. One Suspicion for each reading and kind. Proof: tests/core/measure/screen_test.cpp.
std::vector<Suspicion> bad_readings(const Campaign& campaign);

inline constexpr double kFarTimes = 25;

/// Terms of a smooth field at these targets, a column each: powers of x and y, and phi where it
/// varies; cubic, or of the highest degree that leaves 2.5 rows a term. Precondition: some targets.
Eigen::MatrixXd smooth_terms(std::span<const Pose> targets);

/// What is left of each coordinate after the smooth field, as one robust standard deviation: an
/// upper bound of the noise. Zero degrees of freedom: too few readings to say.
struct SmoothResidual {
  double x_mm = 0, y_mm = 0, phi_rad = 0;
  int degrees_of_freedom = 0;
};
SmoothResidual smooth_residual(const Campaign& campaign);

}  // namespace trammel
