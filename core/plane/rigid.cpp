#include "core/plane/rigid.hpp"

#include <cmath>
#include <complex>

#include "core/error.hpp"
#include "core/linear/products.hpp"
#include "core/linear/singular_values.hpp"

namespace trammel {

Plane fit_plane(std::span<const Eigen::Vector3d> points_mm) {
  Plane plane;
  const auto n = static_cast<Eigen::Index>(points_mm.size());
  if (n == 0) return plane;
  for (const auto& p : points_mm) plane.centre_mm += p / static_cast<double>(n);
  if (n < 3) return plane;
  Eigen::MatrixX3d about(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    about.row(k) = points_mm[static_cast<std::size_t>(k)] - plane.centre_mm;
  }
  const SingularValues svd = singular_values(about);
  const Eigen::VectorXd& s = svd.singular;
  plane.width_mm = s[1];
  plane.observed = s[1] > kNarrow * s[0];
  if (!plane.observed) return plane;
  plane.normal = svd.V.col(2);
  Eigen::Index largest = 0;
  plane.normal.cwiseAbs().maxCoeff(&largest);
  if (plane.normal[largest] < 0) plane.normal = -plane.normal;
  const Eigen::VectorXd d = times(about, plane.normal);
  plane.max_mm = d.cwiseAbs().maxCoeff();
  if (n > 3) plane.rms_mm = std::sqrt(d.squaredNorm() / static_cast<double>(n - 3));
  return plane;
}

PlanarFit fit_planar(std::span<const Eigen::Vector2d> body_mm,
                     std::span<const Eigen::Vector2d> seen_mm) {
  TRAMMEL_ASSERT(!body_mm.empty() && body_mm.size() == seen_mm.size());
  const auto n = static_cast<double>(body_mm.size());
  PlanarFit fit;
  for (const auto& b : body_mm) fit.body_centre_mm += b / n;
  for (const auto& m : seen_mm) fit.seen_centre_mm += m / n;
  // As complex numbers: a turn multiplies by e^(i turn), turning over conjugates.
  std::complex<double> turned = 0, mirrored = 0;
  double seen_mm2 = 0;
  for (std::size_t k = 0; k < body_mm.size(); ++k) {
    const Eigen::Vector2d b = body_mm[k] - fit.body_centre_mm;
    const Eigen::Vector2d m = seen_mm[k] - fit.seen_centre_mm;
    const std::complex<double> body(b.x(), b.y()), seen(m.x(), m.y());
    turned += std::conj(body) * seen;
    mirrored += body * seen;
    fit.spread_mm2 += std::norm(body);
    seen_mm2 += std::norm(seen);
  }
  if (fit.spread_mm2 > 0) {
    fit.turn_rad = std::arg(turned);
    fit.scale = std::sqrt(seen_mm2 / fit.spread_mm2);
  }
  const std::complex<double> turn = std::polar(1.0, fit.turn_rad);
  const std::complex<double> over = std::polar(1.0, std::arg(mirrored));
  double left = 0, left_mirrored = 0;
  for (std::size_t k = 0; k < body_mm.size(); ++k) {  // not S_m + S_b - 2 |A|, which cancels
    const Eigen::Vector2d b = body_mm[k] - fit.body_centre_mm;
    const Eigen::Vector2d m = seen_mm[k] - fit.seen_centre_mm;
    const std::complex<double> body(b.x(), b.y()), seen(m.x(), m.y());
    left += std::norm(seen - turn * body);
    left_mirrored += std::norm(seen - over * std::conj(body));
  }
  const std::complex<double> centre =
      turn * std::complex<double>(fit.body_centre_mm.x(), fit.body_centre_mm.y());
  fit.shift_mm = fit.seen_centre_mm - Eigen::Vector2d(centre.real(), centre.imag());
  if (body_mm.size() > 1) {
    fit.rms_mm = std::sqrt(left / (2 * n - 3));
    fit.mirrored_rms_mm = std::sqrt(left_mirrored / (2 * n - 3));
  }
  return fit;
}

}  // namespace trammel
