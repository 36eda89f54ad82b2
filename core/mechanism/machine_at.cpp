#include "core/mechanism/machine_at.hpp"

#include "core/mechanism/error_model.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/mechanism/velocity.hpp"

namespace trammel {

namespace {

bool has_kernels(const Machine& machine) { return machine.kind->chain == &kPrrChain; }

ForwardResult::Status status_of(MachinePose::Status status) {
  switch (status) {
    case MachinePose::Status::ok:
      return ForwardResult::Status::ok;
    case MachinePose::Status::unreachable:
      return ForwardResult::Status::unreachable;
    case MachinePose::Status::singular:
      return ForwardResult::Status::singular;
  }
  return ForwardResult::Status::not_converged;
}

}  // namespace

MachineSolver::MachineSolver(const Machine& machine) : machine_(machine) {
  if (has_kernels(machine_)) rails_ = rail_frames(geometry_of(machine_));
}

void MachineSolver::move_guides(const Eigen::Vector3d& by_mm) {
  const auto offset = machine_.kind->chain->offset;
  if (!offset) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(machine_.kind->n_chains); ++i) {
    machine_.chains[i][*offset] += by_mm[static_cast<Eigen::Index>(i)];
    rails_.h_mm[i] += by_mm[static_cast<Eigen::Index>(i)];
  }
}

MachineAt MachineSolver::at(const Displacements& q_mm, const Pose& start, bool moment) const {
  MachineAt result;
  if (has_kernels(machine_)) {
    const ForwardResult found = forward(rails_, q_mm, start);
    result.status = found.status;
    if (!found.ok()) return result;
    result.pose = found.pose;
    if (moment) {
      result.angle_rad = link_angles_rad(rails_, found.at);
      result.J_V = velocity_jacobian(velocity_equation(rails_, found.at));
    }
    result.J_e = error_jacobian(rails_, found.at);
    return result;
  }
  Displacements q = q_mm;  // drives that the machine has not stand at 0
  for (int i = machine_.kind->n_chains; i < kChains; ++i) q[i] = 0;
  const MachinePose found = forward(machine_, q, start);
  result.status = status_of(found.status);
  if (!found.ok()) return result;
  result.pose = found.pose;
  const Closures here = closures(machine_, q, found.pose);
  result.J_e = error_jacobian(here);
  if (!moment) return result;
  result.J_V = velocity_jacobian(here);
  if (const auto angle = drives_at(machine_, found.pose).angle) result.angle_rad = (*angle)[0];
  return result;
}

Displacements drives_of(const Machine& machine, const Pose& pose) {
  return has_kernels(machine) ? inverse(geometry_of(machine), pose).l_mm
                              : drives_at(machine, pose).q_mm;
}

}  // namespace trammel
