#include "core/mechanism/machine_solver.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/mechanism/clearance.hpp"
#include "core/mechanism/error_model.hpp"
#include "core/mechanism/velocity.hpp"

namespace trammel {

namespace {

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

MachineSolver::MachineSolver(const Machine& machine)
    : machine_(machine), is_prr_(machine.kind->chain == &kPrrChain) {
  if (!is_prr_) return;
  geometry_ = geometry_of(machine);
  rails_ = rail_frames(geometry_);
}

InverseResult MachineSolver::drives(const Pose& pose) const {
  if (is_prr_) return inverse(geometry_, pose);
  InverseResult result;
  const DrivesAt at = drives_at(machine_, pose);
  if (!at.reached()) {
    result.chain = at.missed;
    return result;
  }
  result.status = InverseResult::Status::ok;
  result.l_mm = at.q_mm;
  result.theta_rad = at.angle ? (*at.angle)[0] : Eigen::Vector3d::Zero();
  return result;
}

MachinePose MachineSolver::pose(const Displacements& l_mm, const Pose& near) const {
  if (!is_prr_) return forward(machine_, l_mm, near);
  const ForwardResult at = forward(rails_, l_mm, near);
  const bool out_of_reach = at.status == ForwardResult::Status::unreachable;
  return {.status = at.ok()        ? MachinePose::Status::ok
                    : out_of_reach ? MachinePose::Status::unreachable
                                   : MachinePose::Status::singular,
          .pose = at.pose,
          .iterations = at.iterations,
          .chain = at.chain};
}

namespace {

double cylinder_clearance_mm(const Machine& machine, const DrivesAt& at) {
  std::array<Link, kChains> cylinders;
  for (std::size_t i = 0; i < kChains; ++i) {
    const auto& [Ax, Ay, l, r, beta, unused_1, unused_2] = machine.chains[i];
    const auto row = static_cast<Eigen::Index>(i);
    const double theta = (*at.angle)[0][row];
    cylinders[i].base = {Ax, Ay};
    cylinders[i].platform =
        cylinders[i].base + (at.q_mm[row] + l) * Eigen::Vector2d(std::cos(theta), std::sin(theta));
  }
  return link_clearance_mm(cylinders);
}

}  // namespace

MachineSolver::Look MachineSolver::look(const Pose& pose) const {
  Look look;
  if (is_prr_) {
    const ChainsAtPose at = chains_at(rails_, pose.vector());
    const VelocityEquation velocity = velocity_equation(rails_, at);
    look.singularity = singularity(geometry_, velocity);
    if (look.singularity.margin() > 0) look.J_V = velocity_jacobian(velocity);
    look.clearance_mm =
        link_clearance_mm(geometry_, {.l_mm = at.l_mm, .theta_rad = link_angles_rad(rails_, at)});
    return look;
  }
  const DrivesAt at = drives_at(machine_, pose);
  const Closures here = closures(machine_, at.q_mm, pose);
  look.singularity = singularity(machine_, here);
  if (look.singularity.margin() > 0) look.J_V = velocity_jacobian(here);
  look.clearance_mm = machine_.kind->chain == &kRprChain ? cylinder_clearance_mm(machine_, at)
                                                         : std::numeric_limits<double>::infinity();
  return look;
}

void MachineSolver::move_guides(const Eigen::Vector3d& by_mm) {
  const auto offset = machine_.kind->chain->offset;
  if (!offset) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(machine_.kind->n_chains); ++i) {
    machine_.chains[i][*offset] += by_mm[static_cast<Eigen::Index>(i)];
    if (!is_prr_) continue;
    rails_.h_mm[i] += by_mm[static_cast<Eigen::Index>(i)];
    geometry_.chains[i].h_mm += by_mm[static_cast<Eigen::Index>(i)];
  }
}

MachineAt MachineSolver::at(const Displacements& q_mm, const Pose& start, bool moment) const {
  MachineAt result;
  if (is_prr_) {
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
  return MachineSolver(machine).drives(pose).l_mm;
}

}  // namespace trammel
