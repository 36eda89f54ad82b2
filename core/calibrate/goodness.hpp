#pragma once
// Whether residuals look like the noise, and what that means for uncertainties.

namespace trammel {

inline constexpr double kFalseMisfit = 0.001;  // a complete model is called incomplete that often

struct Goodness {
  int dof = 0;            // equations less rank
  double ratio = 0;       // of the residuals to the noise: sqrt(chi2 / dof); 0 without freedom
  double limit = 0;       // what chance leaves the ratio below, kFalseMisfit aside
  double least = 0;       // and above
  bool explained = true;  // ratio not beyond the limit
  bool too_good =
      false;         // ratio below the least: sigma is not in the unit that was thought, or large
  double scale = 1;  // of every standard uncertainty
};

/// Judges chi2 = r' W r of a fit, in squared standard deviations of the noise.
///
///   limit^2 = quantile of F(dof, noise_degrees), of chi^2(dof) / dof where the noise is known;
///             least^2 likewise from below
///   scale   = max(1, ratio) for a known noise: what the model lacks counts as uncertainty, a lucky
///             draw does not; ratio for a noise estimated from repeats (GUM: s^2 (J'WJ)^-1)
/// noise_degrees: of freedom of the repeats the noise was estimated from; 0: known. Proof: counted
/// on drawn residuals (limits_test.cpp), coverage (model_uncertainty_test.cpp).
Goodness goodness(double chi2, int dof, int noise_degrees);

}  // namespace trammel
