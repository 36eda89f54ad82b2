#pragma once
// Structure without a name: what errors of robots and trackers look like, so that residuals can be
// tested for anything, and an unexplained gap can be located.

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/diagnose/residual_space.hpp"

namespace trammel {

/// What a shape does at one reading, per unit of its coefficient.
using DeviationOf = std::function<Deviation(const Reading&, const Moment&)>;

/// One shape, with as many columns as it has free coefficients. Columns are whitened, not
/// projected.
struct Shape {
  std::string where;  // "rail 2, l 240 to 262 mm", "readings in x, y, phi"
  std::string when;   // "all", "from 1.2 h on", "moves in + direction"
  Eigen::MatrixXd columns;
  std::vector<DeviationOf> terms = {};  // what the columns were made from: for other readings
};

/// All shapes these readings have the conditions for: per rail polynomials, Fourier terms and local
/// bumps along and across it; direction, its products with travel; temperature and its lag; steps,
/// trends and waves in time; polynomials of the pose and the target orientation.
std::vector<Shape> dictionary(const ResidualSpace& space);

/// The shapes of time alone: trends, steps, waves, settling.
std::vector<Shape> time_courses(const ResidualSpace& space);

}  // namespace trammel
