#pragma once
// Expanded uncertainty of where a corrected robot stands.

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/calibrate/correction.hpp"
#include "core/judge/before_after.hpp"

namespace trammel::assess {

/// How U comes about, in words, and U of the target of a reading.
struct PointUncertainty {
  std::string basis;
  std::function<Expanded(const Reading&)> of;
};

/// From what the correction itself knows of its errors: the covariance of a fitted model
/// (model_uncertainty.hpp), the predictive uncertainty of a Gaussian process with what no place
/// explains, or both (hybrid). Nothing for a correction that knows nothing of them.
/// `fitted`: the readings it was fitted to. Throws InputError as those.
std::optional<PointUncertainty> own_uncertainty(const Correction& correction,
                                                const Mechanism& mechanism,
                                                std::span<const Reading> fitted,
                                                const TrackerSigma& sigma);

/// `of`, widened by what held-out errors (of readings of the same order) show beyond it and the
/// reading's noise, where that is more than chance (two standard deviations of a mean square):
///   u'^2 = u^2 + mean(e^2) - mean(u^2 + sigma^2),   over both coordinates of place, and over phi
/// Precondition: some errors, as many as readings.
PointUncertainty widened(const PointUncertainty& of, std::span<const Reading* const> readings,
                         std::span<const Pose> errors, const TrackerSigma& sigma);

/// From held-out errors alone (expanded_from): the same everywhere.
PointUncertainty held_out_uncertainty(std::span<const Pose> errors, const std::string& whence);

}  // namespace trammel::assess
