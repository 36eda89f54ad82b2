#pragma once

#include <span>

#include "core/plane/place.hpp"

namespace trammel {

struct FittedCircle {
  double x_mm = 0;
  double y_mm = 0;
  double radius_mm = 0;
  double rms_mm = 0;  // of the radial residuals
};

/// The circle with the least sum of squared radial distances (x - x_c)^2 … to the points.
///
/// Starts from the algebraic fit (x^2 + y^2 = a x + b y + c, linear, centred) and iterates
/// Gauss-Newton on d_i = |p_i - c| - R until the step is below 1e-12 of the radius.
/// Throws InputError for fewer than three points, or points in one place or on one line.
/// Proof: exact circles to 1e-12, half arcs, the geometric optimum (circle_test.cpp).
FittedCircle fit_circle(std::span<const Place> points);

}  // namespace trammel
