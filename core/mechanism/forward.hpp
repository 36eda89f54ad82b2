#pragma once

#include "core/mechanism/displacements.hpp"
#include "core/mechanism/geometry.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

struct [[nodiscard]] ForwardResult {
  enum class Status { ok, unreachable, singular, not_converged };
  Status status = Status::not_converged;
  Pose pose = {};  // ok only
  int iterations = 0;
  int chain = 0;         // unreachable, not_converged: the chain that is farthest off, from 0
  ChainsAtPose at = {};  // ok only: for whoever needs the Jacobians next

  [[nodiscard]] bool ok() const { return status == Status::ok; }
};

/// Pose of the platform at joint displacements `l_mm`, by the velocity-Jacobian iteration.
///
///   X <- X + J_V (l - l(X)),   stop when max |l - l(X)| <= 1e-12 * max(1, |l|)              (Fig.
///   3)
/// Starts at `start`; quadratic, so 4 to 6 steps in the workspace. A step is halved while it leaves
/// reach. Source: Zhang et al. 2024, Sec. 2.3. Accuracy: forward(inverse(X)) = X to 1e-9
/// (forward_test.cpp).
ForwardResult forward(const Geometry& geometry, const Displacements& l_mm, const Pose& start = {});
/// The same bits, for many poses of one robot.
ForwardResult forward(const RailFrames& rails, const Displacements& l_mm, const Pose& start = {});

}  // namespace trammel
