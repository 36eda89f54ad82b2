#pragma once
// A machine at its drives' displacements: where the platform stands, and how it follows drives and
// parameters there. The 3-PRR by its kernels, every other kind by its closures.

#include <Eigen/Core>

#include "core/mechanism/displacements.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/machine_kinematics.hpp"

namespace trammel {

struct [[nodiscard]] MachineAt {
  ForwardResult::Status status = ForwardResult::Status::not_converged;
  Pose pose;                                            // this and the rest: ok only
  Eigen::Matrix3d J_V = Eigen::Matrix3d::Zero();        // dX/dq
  ParameterColumns J_e;                                 // dX/dp
  Eigen::Vector3d angle_rad = Eigen::Vector3d::Zero();  // of links or cylinders; 0: it has none

  [[nodiscard]] bool ok() const { return status == ForwardResult::Status::ok; }
};

/// Kinematics of one machine for many displacements.
class MachineSolver {
 public:
  explicit MachineSolver(const Machine& machine);

  /// Moves each guide across itself: a PRR's rail, a PPR's passive guide; others have none.
  void move_guides(const Eigen::Vector3d& by_mm);

  /// forward() of forward.hpp or machine_kinematics.hpp from `start`, and both Jacobians there; J_V
  /// and angles where `moment` is asked for. Proof: the 3-PRR's bits are those of its kernels, the
  /// other kinds' are held to finite differences (robot_model_test.cpp).
  MachineAt at(const Displacements& q_mm, const Pose& start, bool moment) const;

 private:
  Machine machine_;
  RailFrames rails_ = {};  // of a 3-PRR
};

/// Drives at a pose, in closed form: inverse() of the 3-PRR, drives_at() of the rest.
Displacements drives_of(const Machine& machine, const Pose& pose);

}  // namespace trammel
