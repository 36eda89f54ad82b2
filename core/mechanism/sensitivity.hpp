#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/mechanism/machine.hpp"
#include "core/units.hpp"

namespace trammel {

/// Sizes of error the sources are compared at; the paper's, Sec. 3.2.
struct SourceErrors {
  double angle_rad = rad_from_deg(0.001);
  double length_mm = 0.05;
};

/// Rows the machine's coordinates, columns its parameters less those that only complete a chain (of
/// the 3-PRR the paper's 18). Each row sums to 1.
struct SensitivityShares {
  std::vector<MachineParameter> sources;
  Eigen::MatrixXd of;
};

/// Share of each error source in each pose error, over a workspace (global error sensitivity).
///
///   GESI_ij = mean over the poses of |J_ij d_j| / sum_k |J_ik d_k|,   J = J_e of (19)       (20)
/// Source: Zhang et al. 2024, Eq. 20, with absolute values: the printed quotient divides by the
/// signed pose error, which passes through zero inside the workspace.
///
/// Throws InputError when no pose is given or one is out of reach or singular, naming it, and for
/// errors that are negative, not finite or all zero. Proof: rows sum to 1; what Table II says about
/// the chains (sensitivity_test.cpp).
SensitivityShares sensitivity(const Machine& machine, std::span<const Pose> poses,
                              const SourceErrors& errors = {});

}  // namespace trammel
