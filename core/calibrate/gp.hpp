#pragma once
// Gaussian-process regression of joint errors: a map that knows how much it does not know.

#include <array>
#include <span>
#include <vector>

#include "core/calibrate/idw.hpp"
#include "core/calibrate/joint_error.hpp"

namespace trammel {

/// One joint's process: constant mean, covariance s^2 exp(-d^2 / (2 L^2)), noise n^2 on each
/// sample.
struct GpJoint {
  double mean_mm = 0;
  double length_mm = 0;
  double signal_mm = 0;
  double noise_mm = 0;
  Eigen::VectorXd weights;  // (K + n^2 I)^-1 (y - mean), shape (samples)
};

struct GpMap {
  std::vector<double> x_mm, y_mm;
  std::array<GpJoint, 3> joints;
};

/// k, covariances of a process at a place with its samples, s^2 exp(-d^2 / (2 L^2)), shape
/// (samples).
Eigen::VectorXd covariances(const GpMap& map, const GpJoint& joint, Place at);
/// K + n^2 I, covariance of the samples with their noise, shape (samples, samples).
Eigen::MatrixXd covariance(const GpMap& map, const GpJoint& joint);

/// Joint errors at a place: m + k' (K + n^2 I)^-1 (y - m).
Eigen::Vector3d predict(const GpMap& map, Place at);

/// Standard uncertainty of the error itself (without a reading's noise), mm, per joint:
///   u^2 = s^2 - k' (K + n^2 I)^-1 k. Factors K anew: for reports, not for control loops.
std::vector<Eigen::Vector3d> uncertainty_mm(const GpMap& map, std::span<const Place> at);

/// Length and noise share by the largest marginal likelihood over a fixed grid (12 lengths from 20
/// to 900 mm, 19 noise-to-signal ratios from 1e-6 to 1e3), the signal's size in closed form; per
/// joint. Repeats stay apart samples: they tell the noise. Throws InputError for fewer than three
/// places. Proof: recovers a drawn field within its stated uncertainty (gp_test.cpp). Source:
/// Rasmussen and Williams 2006, Eqs. 2.25, 2.26, 5.8.
inline constexpr std::size_t kMostGpSamples = 2000;
GpMap fit_gp(std::span<const JointSample> samples);

}  // namespace trammel
