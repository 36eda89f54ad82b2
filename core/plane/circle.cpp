#include "core/plane/circle.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"

namespace trammel {

namespace {

constexpr int kMaxGaussNewtonSteps = 50;  // a bound: it ends where the step is rounding
constexpr double kStepTolerance = 1e-12;  // of the radius
constexpr double kFlatness = 1e-8;        // narrower than this share of its length is a line

struct Centred {
  Eigen::MatrixX2d p;  // mm, about `mean`
  Eigen::RowVector2d mean;
};

Centred centred(std::span<const Place> points) {
  Centred c;
  c.p.resize(static_cast<Eigen::Index>(points.size()), 2);
  for (std::size_t k = 0; k < points.size(); ++k) {
    c.p.row(static_cast<Eigen::Index>(k)) << points[k].x_mm, points[k].y_mm;
  }
  c.mean = c.p.colwise().mean();
  c.p.rowwise() -= c.mean;
  return c;
}

void require_circle(const Centred& c) {
  if (c.p.rows() >= 3 && orthonormal_basis(c.p, kFlatness).cols() == 2) return;
  throw InputError({.what = "no circle passes through these points",
                    .got = std::to_string(c.p.rows()) + " points, in one place or on one line",
                    .expected = "three or more points of an arc"});
}

/// (x_c, y_c, R) of the algebraic circle: the start.
Eigen::Vector3d algebraic(const Eigen::MatrixX2d& p) {
  Eigen::MatrixXd A(p.rows(), 3);
  A << p, Eigen::VectorXd::Ones(p.rows());
  const Eigen::Vector3d a = shortest_least_squares(A, p.rowwise().squaredNorm());
  return {a[0] / 2, a[1] / 2, std::sqrt(a[2] + (a[0] * a[0] + a[1] * a[1]) / 4)};
}

}  // namespace

FittedCircle fit_circle(std::span<const Place> points) {
  const Centred c = centred(points);
  require_circle(c);
  Eigen::Vector3d v = algebraic(c.p);
  Eigen::VectorXd d(c.p.rows());
  for (int iteration = 0; iteration < kMaxGaussNewtonSteps; ++iteration) {
    Eigen::MatrixXd J(c.p.rows(), 3);
    for (Eigen::Index k = 0; k < c.p.rows(); ++k) {
      const Eigen::Vector2d from = c.p.row(k).transpose() - v.head<2>();
      const double distance = from.norm();
      d[k] = distance - v[2];
      J.row(k) << -from[0] / distance, -from[1] / distance, -1;
    }
    const Eigen::Vector3d step = shortest_least_squares(J, -d);
    v += step;
    if (step.norm() <= kStepTolerance * v[2]) break;
  }
  for (Eigen::Index k = 0; k < c.p.rows(); ++k) {
    d[k] = (c.p.row(k).transpose() - v.head<2>()).norm() - v[2];
  }
  return {.x_mm = v[0] + c.mean[0],
          .y_mm = v[1] + c.mean[1],
          .radius_mm = v[2],
          .rms_mm = std::sqrt(d.squaredNorm() / static_cast<double>(d.size()))};
}

}  // namespace trammel
