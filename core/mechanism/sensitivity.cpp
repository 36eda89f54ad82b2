#include "core/mechanism/sensitivity.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/mechanism/error_model.hpp"

namespace trammel {

SensitivityShares sensitivity(const Geometry& geometry, std::span<const Pose> poses,
                              const SourceErrors& errors) {
  if (poses.empty()) throw InputError({.what = "sensitivity needs at least one pose"});
  const bool sized = std::isfinite(errors.angle_rad) && std::isfinite(errors.length_mm) &&
                     errors.angle_rad >= 0 && errors.length_mm >= 0 &&
                     errors.angle_rad + errors.length_mm > 0;
  if (!sized) {
    throw InputError({.what = "sensitivity cannot be compared at these errors",
                      .got = std::to_string(deg_from_rad(errors.angle_rad)) + " deg, " +
                             std::to_string(errors.length_mm) + " mm",
                      .expected = "finite sizes, not negative, not both zero"});
  }
  Eigen::Matrix<double, 1, kPaperParameters> d;
  for (int j = 0; j < kPaperParameters; ++j) {
    const bool angle = geometry_parameters()[static_cast<std::size_t>(j)].is_angle;
    d[j] = angle ? errors.angle_rad : errors.length_mm;
  }
  SensitivityShares sum = SensitivityShares::Zero();
  const RailFrames frames = rail_frames(geometry);
  for (const Pose& pose : poses) {
    const ChainsAtPose at = chains_at(frames, pose.vector());
    if (!at.reached()) {
      throw InputError({.what = "a pose is out of reach of chain " + std::to_string(at.missed + 1),
                        .got = "x " + std::to_string(pose.x_mm) + " mm, y " +
                               std::to_string(pose.y_mm) + " mm, phi " +
                               std::to_string(deg_from_rad(pose.phi_rad)) + " deg"});
    }
    const ErrorJacobian J = error_jacobian(frames, at);
    SensitivityShares shares;
    for (int i = 0; i < 3; ++i) {
      shares.row(i) = J.block<1, kPaperParameters>(i, 0).cwiseProduct(d).cwiseAbs();
      shares.row(i) /= shares.row(i).sum();
    }
    sum += shares;
  }
  return sum / static_cast<double>(poses.size());
}

}  // namespace trammel
