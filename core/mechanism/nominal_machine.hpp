#pragma once
// The machine as it is stated, under a correction: single poses as MachineSolver has them, and
// tables of them by the kernels of the 3-PRR, side by side, where it is one.

#include <optional>
#include <span>
#include <vector>

#include "core/mechanism/machine_solver.hpp"

namespace trammel {

/// Made of whatever states a machine, so that who asks a question passes what it has.
/// Proof: the bits of the kernels for a 3-PRR (correction_test.cpp, frozen_test.cpp), the solver's
/// for every other kind (corrections_of_machines_test.cpp).
class NominalMachine : public MachineSolver {
 public:
  NominalMachine(const Machine& machine);      // NOLINT(google-explicit-constructor)
  NominalMachine(const Mechanism& mechanism);  // NOLINT(google-explicit-constructor)

  /// As inverse_displacements: drives at a pose, nothing where a chain does not reach it.
  [[nodiscard]] std::optional<Displacements> displacements(const Pose& pose) const;

  /// The same by chains_at, as what is measured is turned into joint errors; names the chain.
  [[nodiscard]] InverseResult chains(const Pose& pose) const;

  /// As poses_at: `poses` holds where to look first and then what was found; returns which were
  /// not. A coordinate that the machine has not stays where it was.
  [[nodiscard]] std::vector<std::size_t> poses(std::span<const Displacements> l_mm,
                                               std::span<Pose> poses) const;

  /// `pose` where a coordinate is measured, `otherwise` where it is not.
  [[nodiscard]] Pose measured_else(const Pose& pose, const Pose& otherwise) const;
  /// Whether every coordinate that the machine moves is measured.
  [[nodiscard]] bool measures_all() const;
  /// dX/dl with 1 on the diagonal of drives and coordinates that the machine has not: it can be
  /// inverted, and moves none of them.
  [[nodiscard]] Eigen::Matrix3d invertible(const Eigen::Matrix3d& J_V) const;

 private:
  std::optional<RailFrames> rails_;  // of a 3-PRR
};

}  // namespace trammel
