#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/mechanism/geometry.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

/// Joint displacements and link angles at a pose, or the first chain that cannot reach it.
struct [[nodiscard]] InverseResult {
  enum class Status { ok, unreachable };
  Status status = Status::unreachable;
  int chain = 0;                   // unreachable: the chain, from 0
  Displacements l_mm = {};         // ok only
  Eigen::Vector3d theta_rad = {};  // ok only: link angles of B_i C_i against X

  [[nodiscard]] bool ok() const { return status == Status::ok; }
};

/// Joint displacements that put the platform at `pose` (inverse kinematics, closed form).
///
/// Per chain solves the loop closure     |C_i - B_i(l_i)| = S_i                              (1)
///   Q = C_i + R u - h n,   l = Q.u - sqrt(S^2 - (Q.n)^2) - l_zero                           (4)
///   C_i = O_C + r (cos(beta + phi), sin(beta + phi)): the sign of r as corrected
/// The minus branch is the paper's working mode: cos(alpha - theta) > 0.
/// Source: Zhang et al. 2024, Eqs. 1-4; symbols as in core/README.md.
///
/// Unreachable: the first chain with |Q.n| > S.
/// Accuracy: |(1)| < 1e-9 mm and the golden numbers to 1e-9 mm (inverse_test.cpp). No allocation.
InverseResult inverse(const Geometry& geometry, const Pose& pose);

/// The same for a grid of poses, chain by chain; results in the order of `poses`.
std::vector<InverseResult> inverse(const Geometry& geometry, std::span<const Pose> poses);

}  // namespace trammel
