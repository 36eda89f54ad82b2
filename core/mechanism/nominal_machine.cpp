#include "core/mechanism/nominal_machine.hpp"

#include "core/mechanism/poses.hpp"

namespace trammel {

NominalMachine::NominalMachine(const Machine& machine) : MachineSolver(machine) {
  if (machine.kind->chain == &kPrrChain) rails_ = rail_frames(geometry_of(machine));
}

NominalMachine::NominalMachine(const Mechanism& mechanism)
    : NominalMachine(machine_of(mechanism)) {}

std::optional<Displacements> NominalMachine::displacements(const Pose& pose) const {
  if (rails_) return inverse_displacements(*rails_, pose);
  const InverseResult at = drives(pose);
  return at.ok() ? std::optional(at.l_mm) : std::nullopt;
}

InverseResult NominalMachine::chains(const Pose& pose) const {
  if (!rails_) return drives(pose);
  const ChainsAtPose at = chains_at(*rails_, pose.vector());
  InverseResult result;
  result.chain = at.missed;
  if (!at.reached()) return result;
  result.status = InverseResult::Status::ok;
  result.l_mm = at.l_mm;
  return result;
}

std::vector<std::size_t> NominalMachine::poses(std::span<const Displacements> l_mm,
                                               std::span<Pose> poses) const {
  if (rails_) return poses_at(*rails_, l_mm, poses);
  std::vector<std::size_t> missed;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const MachinePose found = pose(l_mm[k], poses[k]);
    if (found.ok()) {
      poses[k] = found.pose;
    } else {
      missed.push_back(k);
    }
  }
  return missed;
}

Pose NominalMachine::measured_else(const Pose& pose, const Pose& otherwise) const {
  Eigen::Vector3d values = otherwise.vector();
  for (int c = 0; c < 3; ++c) {
    if (machine().measured[static_cast<std::size_t>(c)]) values[c] = pose.vector()[c];
  }
  return Pose::from(values);
}

bool NominalMachine::measures_all() const {
  for (int c = 0; c < machine().kind->n_chains; ++c) {
    if (!machine().measured[static_cast<std::size_t>(c)]) return false;
  }
  return true;
}

Eigen::Matrix3d NominalMachine::invertible(const Eigen::Matrix3d& J_V) const {
  Eigen::Matrix3d J = J_V;
  for (int i = machine().kind->n_chains; i < kChains; ++i) J(i, i) = 1;
  return J;
}

}  // namespace trammel
