#pragma once
// Expanded uncertainty of where a corrected robot stands.

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/calibrate/correction.hpp"
#include "core/judge/before_after.hpp"

namespace trammel {

/// How U comes about, in words, and U of the target of a reading, within the range that was fitted.
struct PointUncertainty {
  std::string basis;
  std::function<Expanded(const Reading&)> of;
};

/// From what the correction itself knows of its errors: the covariance of a fitted model and its
/// lack of fit (model_uncertainty.hpp), what a map misses of a random field like its samples
/// (map_uncertainty.hpp), or both (hybrid). The robot's own, without a reading's noise. Nothing
/// without a correction, and for more readings than a field is fitted to.
/// `fitted`: the readings it was fitted to. Throws InputError as those. Proof: coverage by
/// simulation (uncertainty_test.cpp).
std::optional<PointUncertainty> own_uncertainty(const Correction& correction,
                                                const NominalMachine& machine,
                                                std::span<const Reading> fitted,
                                                const TrackerSigma& sigma);

/// A reading that was not fitted, within range, and what was left of its error.
struct HeldOut {
  const Reading* reading = nullptr;
  Pose error;
  Coordinates measured = {true, true, true};  // what is not measured says nothing
};

inline constexpr std::size_t kFewestHeldOut = 10;  // a mean square is then known to 30 %

/// `own` as held-out errors correct it, over both coordinates of place, and over phi. Where what is
/// expected is more than a reading's noise, its shape is seen: it is scaled so that 95.45 % of the
/// coordinates lie within k = 2 of it and the noise,
///   f: share of |e_i| <= 2 sqrt(f^2 u_i^2 + sigma^2) is 0.9545 (n + 1) / n
/// else only its size, u'^2 = u^2 + max(0, mean(e^2) - mean(u^2) - sigma^2), with t of
/// n (u'^2 / (u'^2 + sigma^2))^2 degrees of freedom (Welch and Satterthwaite, GUM G.4) in place of
/// k = 2. The point that is judged is left out. f below 1 holds within the hull of the held-out
/// points alone: near the middle of what was fitted errors are smaller, and say nothing of its
/// edge. Without `may_narrow` it holds nowhere: cross-validated errors are those of other fits.
/// `own` for fewer than kFewestHeldOut errors. Proof: coverage where held-out points lie near the
/// middle (uncertainty_test.cpp).
PointUncertainty calibrated(const PointUncertainty& own, std::span<const HeldOut> held_out,
                            const TrackerSigma& sigma, bool may_narrow = true);

/// From held-out errors alone, the same everywhere but that the point that is judged is left out:
///   u^2 = mean(e^2) - sigma^2,   the noise that would leave nothing aside
/// Precondition: two errors or more.
PointUncertainty held_out_uncertainty(std::span<const HeldOut> held_out, const std::string& whence,
                                      const TrackerSigma& sigma);

}  // namespace trammel
