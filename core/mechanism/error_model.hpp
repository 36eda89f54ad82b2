#pragma once

#include <Eigen/Core>

#include "core/mechanism/displacements.hpp"
#include "core/mechanism/geometry.hpp"

namespace trammel {

using ErrorJacobian = Eigen::Matrix<double, 3, kGeometryParameters>;

/// How the pose at given displacements follows small errors of the geometry: delta X = J_e delta d.
///
///   cos(theta) dx + sin(theta) dy - r sin(gamma - theta) dphi
///     = (R - l) sin(alpha - theta) dalpha + r sin(gamma - theta) dbeta - cos(gamma - theta) dr
///       + dS + cos(alpha - theta) (dl - dR) - sin(alpha - theta) dh                          (18)
/// and a rail offset h also turns with alpha: - h cos(alpha - theta) dalpha; gamma = beta + phi, l
/// the displacement with its zero. J_e = J_1^-1 J_2 (19), rows x, y [mm], phi [rad]; columns in the
/// order of geometry_parameters(), rad and mm. The paper's 18 are the first columns. Source: Zhang
/// et al. 2024, Eqs. 14-19 as corrected (Eq. 17 is skipped: 18 is right as printed). Proof: golden
/// numbers to 1e-9 relative, finite differences of the forward kinematics (error_model_test.cpp).
/// Precondition: the pose is not singular.
ErrorJacobian error_jacobian(const RailFrames& frames, const ChainsAtPose& at);

}  // namespace trammel
