#pragma once
// One way to ask where a machine stands, whatever its kind: by the kernels of the 3-PRR where it is
// one, whose bits are those of every stored result, else by its closures.

#include <Eigen/Core>

#include "core/mechanism/displacements.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/mechanism/machine.hpp"
#include "core/mechanism/machine_kinematics.hpp"

namespace trammel {

/// How the platform stands at some displacements, and follows drives and parameters there.
struct [[nodiscard]] MachineAt {
  ForwardResult::Status status = ForwardResult::Status::not_converged;
  Pose pose;                                            // this and the rest: ok only
  Eigen::Matrix3d J_V = Eigen::Matrix3d::Zero();        // dX/dq
  ParameterColumns J_e;                                 // dX/dp
  Eigen::Vector3d angle_rad = Eigen::Vector3d::Zero();  // of links or cylinders; 0: it has none

  [[nodiscard]] bool ok() const { return status == ForwardResult::Status::ok; }
};

/// Proof of all: the kernels' bits for a 3-PRR, and drives -> pose -> drives for every kind
/// (machine_solver_test.cpp).
class MachineSolver {
 public:
  explicit MachineSolver(const Machine& machine);

  [[nodiscard]] const Machine& machine() const { return machine_; }

  /// As `inverse` and `drives_at`: displacements, and angles of links and cylinders where there are
  /// any.
  [[nodiscard]] InverseResult drives(const Pose& pose) const;
  /// As `forward`, from `near`.
  [[nodiscard]] MachinePose pose(const Displacements& l_mm, const Pose& near) const;

  /// The same with both Jacobians there; J_V and angles where `moment` is asked for. Proof: the
  /// 3-PRR's bits are those of its kernels, the other kinds' are held to finite differences
  /// (robot_model_test.cpp).
  [[nodiscard]] MachineAt at(const Displacements& l_mm, const Pose& near, bool moment) const;

  /// Moves each guide across itself: a PRR's rail, a PPR's passive guide; others have none.
  void move_guides(const Eigen::Vector3d& by_mm);

  /// How the machine stands at a pose. Precondition: `drives` reaches it.
  struct Look {
    Singularity singularity;
    Eigen::Matrix3d J_V = Eigen::Matrix3d::Zero();  // dX/dl; 0 at a singular pose
    double clearance_mm = 0;  // as link_clearance_mm; infinite where nothing but guides moves
  };
  [[nodiscard]] Look look(const Pose& pose) const;

 private:
  Machine machine_;
  bool is_prr_ = false;
  Geometry geometry_;  // 3-PRR only, and its frames
  RailFrames rails_ = {};
};

/// Drives at a pose that the machine reaches.
Displacements drives_of(const Machine& machine, const Pose& pose);

}  // namespace trammel
