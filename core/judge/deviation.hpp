#pragma once
// How far a pose is from where it should be, and how well numbers predict numbers.

#include <optional>
#include <span>

#include "core/mechanism/pose.hpp"

namespace trammel {

/// Distance of the platform centres, mm: the paper's position error.
double position_error_mm(const Pose& measured, const Pose& wanted);

/// |phi measured - phi wanted|, the shorter way round, rad: the paper's attitude error.
double attitude_error_rad(const Pose& measured, const Pose& wanted);

/// Difference of two poses with phi taken the shorter way round: (mm, mm, rad).
Eigen::Vector3d pose_difference(const Pose& measured, const Pose& wanted);

/// How predictions meet what was measured.
struct FitScores {
  double mae = 0;                    // mean |predicted - measured|                      (25)
  double mse = 0;                    // mean square, unit squared                        (26)
  std::optional<double> r2_pearson;  // squared correlation (27): blind to bias and scale
  std::optional<double> r2;          // 1 - SSE / SST
};

/// Scores of `predicted` against `measured`, of equal length. The two R^2 are absent where they are
/// not defined: fewer than two values, or a constant column. Source: Zhang et al. 2024, Eqs. 25-27
/// (27 is the squared Pearson correlation, not the coefficient of determination: both are given).
/// Throws InputError when the lengths differ or nothing is there. Proof: deviation_test.cpp.
FitScores fit_scores(std::span<const double> predicted, std::span<const double> measured);

}  // namespace trammel
