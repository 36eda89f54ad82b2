#include "core/measure/lie.hpp"

#include <algorithm>
#include <cmath>

#include "core/statistics/robust.hpp"
#include "core/units.hpp"

namespace trammel::poses {

namespace {

double width_of(const std::vector<Complex>& points) {
  std::vector<double> x, y;
  for (const Complex& p : points) {
    x.push_back(p.real());
    y.push_back(p.imag());
  }
  return std::hypot(robust_scatter(std::move(x)), robust_scatter(std::move(y)));
}

AngleFit angles(const Poses& from, const Poses& to, double slope, bool free_offset) {
  std::vector<double> off;
  for (std::size_t k = 0; k < from.size(); ++k)
    off.push_back(wrapped(to[k].phi_rad - slope * from[k].phi_rad));
  AngleFit fit{.slope = slope, .offset_rad = free_offset ? middle_of_angles(off) : 0};
  for (double& v : off) v = wrapped(v - fit.offset_rad);
  fit.left_rad = robust_sigma(off) / std::abs(slope);
  return fit;
}

/// The slope about the middles by least squares, without what stays beyond four medians.
void fit_slope(const Poses& from, const Poses& to, AngleFit& fit) {
  constexpr int kTrims = 3;
  constexpr double kFar = 4;
  std::vector<double> u, v;
  for (const Pose& p : from) u.push_back(p.phi_rad);
  for (const Pose& p : to) v.push_back(p.phi_rad);
  const double middle_u = middle_of_angles(u), middle_v = middle_of_angles(v);
  for (double& a : u) a = wrapped(a - middle_u);
  for (double& a : v) a = wrapped(a - middle_v);
  std::vector<bool> keep(u.size(), true);
  for (int round = 0; round < kTrims; ++round) {
    double n = 0, su = 0, sv = 0, uu = 0, uv = 0, left2 = 0;
    for (std::size_t k = 0; k < u.size(); ++k) {
      if (!keep[k]) continue;
      n += 1;
      su += u[k];
      sv += v[k];
      uu += u[k] * u[k];
      uv += u[k] * v[k];
    }
    const double spread = uu - su * su / n;
    if (!(spread > 0) || n < 3) return;
    fit.fitted_slope = (uv - su * sv / n) / spread;
    const double offset = (sv - fit.fitted_slope * su) / n;
    std::vector<double> left;
    for (std::size_t k = 0; k < u.size(); ++k) {
      left.push_back(std::abs(v[k] - offset - fit.fitted_slope * u[k]));
      if (keep[k]) left2 += left.back() * left.back();
    }
    fit.slope_error = std::sqrt(left2 / (n - 2) / spread);
    const double limit = kFar * median(left);
    for (std::size_t k = 0; k < u.size(); ++k) keep[k] = left[k] <= limit;
  }
}

/// In angles of either side: a large slope makes everything small on one of them.
bool far_better(const AngleFit& fit, const AngleFit& than) {
  return fit.left_rad * kFarBetter < than.left_rad &&
         fit.left_rad * std::abs(fit.slope) * kFarBetter < than.left_rad;
}

/// Equal slopes unless another is far better: the wrong sign, another unit.
AngleFit angles(const Poses& from, const Poses& to) {
  const AngleFit as_is = angles(from, to, 1, true);
  AngleFit best = as_is;
  std::vector<double> own;  // of `to` about its middle: whole turns of a large slope say nothing
  for (const Pose& p : to) own.push_back(p.phi_rad);
  const double middle = middle_of_angles(own);
  for (double& v : own) v = wrapped(v - middle);
  const double spread = robust_sigma(own);
  const auto consider = [&](double slope) {
    const AngleFit fit = angles(from, to, slope, true);
    if (slope > 1 && fit.left_rad * slope * kFarBetter > spread) return;
    if (far_better(fit, as_is) && fit.left_rad < best.left_rad) best = fit;
  };
  consider(-1);
  for (const AngleUnit& unit : kAngleUnits) consider(unit.slope);
  fit_slope(from, to, best);
  if (best.slope != 1) return best;
  for (const AngleUnit& unit : kAngleUnits) {
    AngleFit fit = angles(from, to, unit.slope, true);
    fit.fitted_slope = best.fitted_slope;
    fit.slope_error = best.slope_error;
    if (fit.is_fitted()) return fit;
  }
  for (const double slope : {rad_from_deg(1), deg_from_rad(1)}) {  // at one orientation
    const AngleFit fit = angles(from, to, slope, false);
    if (far_better(fit, angles(from, to, 1, false))) best = fit;
  }
  return best;
}

}  // namespace

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * kPi); }

double middle_of_angles(const std::vector<double>& angles_rad) {
  Complex mean = 0;
  for (const double a : angles_rad) mean += std::polar(1.0, a);
  const double middle = std::arg(mean);
  std::vector<double> off;
  for (const double a : angles_rad) off.push_back(wrapped(a - middle));
  return wrapped(middle + median(off));
}

Similarity similarity(const Points& points, bool mirrored, bool rigid) {
  constexpr int kTrims = 4;
  constexpr double kFar = 4;
  const std::size_t n = points.from.size();
  const bool narrow = width_of(points.from) < kNarrowMm;
  Similarity fit{.mirrored = mirrored};
  std::vector<bool> keep(n, true);
  std::vector<double> left(n);
  for (int round = 0; round < kTrims; ++round) {
    const auto from = [&](std::size_t k) {
      return mirrored ? std::conj(points.from[k]) : points.from[k];
    };
    Complex mean_p = 0, mean_m = 0, sum = 0;
    double kept = 0, pp = 0;
    for (std::size_t k = 0; k < n; ++k) {
      if (!keep[k]) continue;
      mean_p += from(k);
      mean_m += points.to[k];
      kept += 1;
    }
    mean_p /= kept;
    mean_m /= kept;
    for (std::size_t k = 0; k < n; ++k) {
      if (!keep[k]) continue;
      sum += std::conj(from(k) - mean_p) * (points.to[k] - mean_m);
      pp += std::norm(from(k) - mean_p);
    }
    if (!narrow && pp > 0 && std::abs(sum) > 0) {
      fit.turn_rad = std::arg(sum);
      fit.scale = rigid ? 1 : std::abs(sum) / pp;
    }
    fit.shift_mm = mean_m - std::polar(fit.scale, fit.turn_rad) * mean_p;
    for (std::size_t k = 0; k < n; ++k) left[k] = std::abs(fit.back(points.to[k]) - points.from[k]);
    const double limit = kFar * median(left);
    for (std::size_t k = 0; k < n; ++k) keep[k] = left[k] <= limit;
  }
  fit.left_mm = robust_sigma(left);
  return fit;
}

std::vector<double> distances_mm(const Poses& a, const Poses& b, int shift) {
  std::vector<double> off;
  const auto n = static_cast<int>(a.size());
  for (int k = std::max(0, -shift); k < n - std::max(0, shift); ++k) {
    const Pose& p = a[static_cast<std::size_t>(k)];
    const Pose& q = b[static_cast<std::size_t>(k + shift)];
    off.push_back(
        std::hypot(p.x_mm - q.x_mm, p.y_mm - q.y_mm, kArmMm * wrapped(p.phi_rad - q.phi_rad)));
  }
  return off;
}

double off_mm(const Poses& a, const Poses& b) { return robust_sigma(distances_mm(a, b)); }

Points points_of(const Poses& from, const Poses& to) {
  Points points;
  for (std::size_t k = 0; k < from.size(); ++k) {
    points.from.push_back(place_of(from[k]));
    points.to.push_back(place_of(to[k]));
  }
  return points;
}

Lie lie(const Poses& from, const Poses& to) {
  const Points points = points_of(from, to);
  Lie l{.place = similarity(points, false, false),
        .angle = angles(from, to),
        .width_mm = width_of(points.from),
        .off_mm = off_mm(from, to)};
  const Similarity mirrored = similarity(points, true, false);
  if (l.width_mm > kNarrowMm && mirrored.left_mm * kFarBetter < l.place.left_mm) l.place = mirrored;
  return l;
}

}  // namespace trammel::poses
