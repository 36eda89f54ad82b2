#pragma once
// How one column of poses lies on another: by a similarity, straight or mirrored, and a line of the
// orientations. Robust: a quarter of wild readings decides nothing.

#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include "core/mechanism/pose.hpp"
#include "core/units.hpp"

namespace trammel::poses {

using Complex = std::complex<double>;
using Poses = std::vector<Pose>;

inline constexpr double kFarBetter = 5;       // a hypothesis must fit so many times better
inline constexpr double kSimilarShare = 0.1;  // of the width: what a similarity may leave
inline constexpr double kNarrowMm = 0.25;     // targets nearer together show no turn and no scale

inline constexpr double kArmMm = 100;  // an orientation counts by what it moves at this arm
inline constexpr double kOneOrientationRad = rad_from_deg(0.05);  // orientations within it are one

inline Complex place_of(const Pose& p) { return {p.x_mm, p.y_mm}; }
double wrapped(double angle_rad);  // by whole turns into [-pi, pi]

/// Median about the direction of the mean: angles count modulo a turn.
double middle_of_angles(const std::vector<double>& angles_rad);

/// to = scale e^(i turn) from + shift in the complex plane, of conj(from) where mirrored.
struct Similarity {
  bool mirrored = false;
  double scale = 1;
  double turn_rad = 0;
  Complex shift_mm = 0;
  double left_mm = 0;  // robust, in lengths of `from`

  [[nodiscard]] Complex back(Complex to) const {
    const Complex from = (to - shift_mm) / std::polar(scale, turn_rad);
    return mirrored ? std::conj(from) : from;
  }
};

struct Points {
  std::vector<Complex> from, to;
};

/// Least squares, z = sum conj(p) m / sum |p|^2 about the means, on the points that are left when
/// those beyond four medians of the residuals go, three times over. `rigid`: with scale 1.
Similarity similarity(const Points& points, bool mirrored, bool rigid);

/// What numbers of another unit are, read as degrees: so many times the angles.
struct AngleUnit {
  double slope;
  const char* words;
};
inline constexpr std::array<AngleUnit, 7> kAngleUnits = {
    {{rad_from_deg(1), "are radians where degrees are due"},
     {deg_from_rad(1), "were converted from degrees twice"},
     {1e3 * rad_from_deg(1), "are milliradians where degrees are due"},
     {10.0 / 9, "are gradians where degrees are due"},
     {60, "are minutes of arc where degrees are due"},
     {3600, "are seconds of arc where degrees are due"},
     {1.0 / 360, "are turns where degrees are due"}}};

/// to = slope from + offset, angles modulo a turn.
struct AngleFit {
  double slope = 1;
  double offset_rad = 0;
  double left_rad = 0;                              // robust, in angles of `from`
  double fitted_slope = 1, slope_error = INFINITY;  // by least squares, and its standard error

  /// The slope is that of the unit beyond doubt: no geometry turns phi by so much.
  [[nodiscard]] bool is_fitted() const {
    constexpr double kOneSlope = 0.015, kSure = 6;
    return std::abs(fitted_slope - slope) < kOneSlope * slope && slope_error < kOneSlope * slope &&
           slope_error * kSure < std::abs(slope - 1);
  }
};

struct Lie {
  Similarity place;
  AngleFit angle;
  double width_mm = 0;
  double off_mm = 0;  // robust distance as they are

  /// A similarity explains the positions, or there is too little of them to tell.
  [[nodiscard]] bool similar() const {
    return width_mm < kNarrowMm || place.left_mm < kSimilarShare * width_mm;
  }
  [[nodiscard]] Pose back(const Pose& to) const {
    const Complex p = place.back(place_of(to));
    return {p.real(), p.imag(), wrapped(to.phi_rad - angle.offset_rad) / angle.slope};
  }
};

/// Of `to` on `from`; mirrored, or with another slope, where that fits far better or is what a
/// fitted slope says beyond doubt (gradians over a few degrees).
/// Proof: tests/core/measure/mistakes_test.cpp.
Lie lie(const Poses& from, const Poses& to);

Points points_of(const Poses& from, const Poses& to);

/// Row k of `a` from row k + shift of `b`, orientations by what they move at an arm of 100 mm.
std::vector<double> distances_mm(const Poses& a, const Poses& b, int shift = 0);
double off_mm(const Poses& a, const Poses& b);  // robust, of distances_mm

}  // namespace trammel::poses
