#pragma once
// Is the base that a fit found one that a robot of this kind can have?

#include <string>

#include "core/calibrate/geometry_fit.hpp"

namespace trammel {

/// The tolerances are standard deviations of machining (geometry.hpp); a robot three times as bad
/// in every parameter is still one of its kind. Nothing that a base takes up of an effect of usual
/// size goes beyond that once the effect is in the model.
inline constexpr double kBuilt = 3.0;
/// Of a robot that is kBuilt times as bad as stated; one built as stated is never that far off
/// (p < 1e-30 for nine directions). Rates that were counted: README.md.
inline constexpr double kImplausible = 0.001;

/// What a fitted geometry is off, in what the readings tell of it and no frame explains.
struct BaseDistance {
  double tolerances = 0;  // root mean square over the directions
  double chi2 = 0;        // D, below
  double p = 1;           // that a robot built kBuilt times as badly as stated is as far off
  int directions = 0;     // 0: these readings tell nothing of the robot that a frame does not
  [[nodiscard]] bool implausible() const { return p <= kImplausible; }
};

/// Distance of `fit`'s geometry from the one it is stated to have.
///
/// First the stated robot is laid onto the fitted one, exactly: its platform by the rigid move of
/// the plane that brings the joints C_i closest (a reflector that is not at O_C, an attitude that
/// is not zero), its rails by a turn and a shift (the tracker's frame), its joint zeros as fitted.
/// z: what is left, in tolerances. With V the identified directions (covariance S^-2) and N what
/// frame, reflector, zeros, epochs and effects change to first order,
///   y = V' z,   U = V's complement of V' N,   t = U' y,
///   D = t' (kBuilt^2 I + U' S^-2 U)^-1 t ~ chi^2(directions)
/// for a robot whose parameters are all off by kBuilt tolerances (one standard deviation).
/// Proof: frames, reflectors and homings of any size leave nothing, machining is never alarmed,
/// a stage that is no such robot is (plausible_test.cpp).
BaseDistance base_distance(const GeometryFit& fit);

/// "12 tolerances off nominal in the 9 combinations …, where … stays below 5.3".
std::string in_words(const BaseDistance& distance);

}  // namespace trammel
