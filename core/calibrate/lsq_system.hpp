#pragma once
// The overdetermined system of all readings, as lsq.hpp solves it.

#include <map>
#include <span>
#include <vector>

#include "core/calibrate/lsq.hpp"

namespace trammel {

/// min |A z - b|: rows in standard deviations (x, y, phi of each reading), columns in tolerances.
struct LsqSystem {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  std::vector<ScaledParameter> parameters;
  std::vector<int> epochs;  // of each column, 1 for the geometry
  std::vector<Pose> poses;  // modelled, of each reading: where the next linearisation looks first
};

/// The readings linearised at `mechanism` and, for later epochs, at `offsets`:
///   b_j = W (measured - frame * forward(cmd + zeros)),   A_j = W J_e                   (19, 21)
/// W = 1 / sigma of the tracker; phi's times `attitude_weight`. Throws as identify_linear.
LsqSystem lsq_system(const Mechanism& mechanism, std::span<const Reading> readings,
                     const TrackerSigma& sigma, const LsqOptions& options,
                     const std::map<int, EpochShift>& offsets = {});
/// The same rows again, linearised elsewhere.
void linearise(LsqSystem& system, const Mechanism& mechanism, std::span<const Reading> readings,
               const TrackerSigma& sigma, const LsqOptions& options,
               const std::map<int, EpochShift>& offsets);

}  // namespace trammel
