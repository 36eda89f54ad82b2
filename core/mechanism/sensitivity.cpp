#include "core/mechanism/sensitivity.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/mechanism/machine_kinematics.hpp"

namespace trammel {

namespace {

[[noreturn]] void refuse_pose(const Pose& pose, const std::string& what) {
  throw InputError({.what = what,
                    .got = "x " + std::to_string(pose.x_mm) + " mm, y " +
                           std::to_string(pose.y_mm) + " mm, phi " +
                           std::to_string(deg_from_rad(pose.phi_rad)) + " deg"});
}

}  // namespace

SensitivityShares sensitivity(const Machine& machine, std::span<const Pose> poses,
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
  SensitivityShares shares;
  for (const MachineParameter& p : parameters_of(*machine.kind)) {  // those that complete come last
    if (!p.completes) shares.sources.push_back(p);
  }
  const auto n = static_cast<Eigen::Index>(shares.sources.size());
  Eigen::RowVectorXd d(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const bool angle = shares.sources[static_cast<std::size_t>(j)].is_angle;
    d[j] = angle ? errors.angle_rad : errors.length_mm;
  }
  shares.of = Eigen::MatrixXd::Zero(machine.kind->n_chains, n);
  for (const Pose& pose : poses) {
    const DrivesAt at = drives_at(machine, pose);
    if (!at.reached()) {
      refuse_pose(pose, "a pose is out of reach of chain " + std::to_string(at.missed + 1));
    }
    const Closures here = closures(machine, at.q_mm, pose);
    if (singularity(machine, here).margin() < kSingularMargin) {
      refuse_pose(pose, "a pose is singular: errors have no size there");
    }
    const ParameterColumns J = error_jacobian(here);
    for (Eigen::Index i = 0; i < shares.of.rows(); ++i) {
      const Eigen::RowVectorXd parts = J.row(i).head(n).cwiseProduct(d).cwiseAbs();
      const double sum = parts.sum();
      if (sum > 0) shares.of.row(i) += parts / (sum * static_cast<double>(poses.size()));
    }
  }
  return shares;
}

}  // namespace trammel
