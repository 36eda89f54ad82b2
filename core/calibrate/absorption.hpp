#pragma once
// The absorption alarm: does the model say the same from one half of the readings as from the
// other?

#include <span>
#include <string>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"

namespace trammel {

/// What two halves disagree on: a parameter, or a combination that both identify.
struct HalfShift {
  std::string name;       // "l_1", "+0.81 l_1 -0.55 R_1 (in tolerances)"
  bool single = false;    // one parameter, in its own unit; else a combination, in tolerances
  std::string unit = {};  // of the report; an angle of the geometry is in rad and shown in deg
  bool is_angle = false;
  double shift = 0;  // second half less first: mm, rad, the effect's unit; or tolerances
  double standard_uncertainty = 0;
  [[nodiscard]] double sigmas() const { return shift / standard_uncertainty; }
};

/// One way to halve the readings.
struct HalvesTest {
  int tests = 0;                  // parameters and combinations compared; 0: see `untested`
  double limit_sigmas = 0;        // beyond it a shift counts
  double noise_ratio = 1;         // of the residuals within the halves to the noise, at least 1
  std::vector<HalfShift> shifts;  // those that count, the surest first
  std::string untested;           // why nothing could be compared
};

struct AbsorptionTest {
  HalvesTest in_time;      // the first half of the readings against the second
  HalvesTest interleaved;  // every other reading against the rest: the control
  double false_alarm = 0;  // of each test over all it compares, for a complete model
};

inline constexpr double kFalseAbsorption = 0.01;

/// Compares the identified parameters and combinations between halves of `readings`, to which `fit`
/// was made.
///
/// Linearised at the fit, with B the whitened Jacobian on the identified directions, half by half
///   y_h = (B_h' B_h)^-1 B_h' r_h,   Cov(y_2 - y_1) = s^2 ((B_1' B_1)^-1 + (B_2' B_2)^-1)
/// on the directions that both halves know; s^2 = chi^2 within the halves over its degrees of
/// freedom, at least 1. A shift counts beyond Student's t of false_alarm / tests, two-sided
/// (Bonferroni), tests = combinations (principal axes of that covariance: independent) and single
/// parameters. Halves by time where it is recorded, else by seq. A shift in time that the control
/// does not show is an unmodelled effect of time; one that the control shows too is not.
/// Proof: false alarms and found drifts counted (absorption_test.cpp).
AbsorptionTest absorption_test(const GeometryFit& fit, std::span<const Reading> readings,
                               double false_alarm = kFalseAbsorption);

}  // namespace trammel
