#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/linear/cpu_level.hpp"
#include "core/mechanism/displacements.hpp"

namespace trammel {

/// Poses at many displacements of one robot and how each follows the errors of its geometry: the
/// forward kinematics of forward.hpp and the error Jacobian (19) of error_model.hpp, several poses
/// side by side. `poses` holds where to look first and then what was found; rows 3 j to 3 j + 2 of
/// `J`, shape (3 N, 21), are the Jacobian of the j-th.
///
/// @return  which were not found, in order, with `poses` and `J` undefined there: forward() tells
///          why, and takes shorter steps
/// Within 1e-9 mm and rad of the two functions; the same bits for a pose wherever it stands in the
/// batch, and on every level of CPU (error_model_test.cpp).
std::vector<std::size_t> error_rows(const RailFrames& frames, std::span<const Displacements> l_mm,
                                    std::span<Pose> poses, Eigen::MatrixXd& J,
                                    CpuLevel level = cpu_level());

}  // namespace trammel
