#include "core/calibrate/design.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "core/plan/grids.hpp"

namespace trammel {

namespace {

constexpr int kComparisonSteps = 4;          // from the middle to the border
constexpr double kComparisonApproachMm = 5;  // one approach for all candidates

[[noreturn]] void out_of_reach(const std::string& point) {
  throw InputError({.what = "a target is out of the nominal robot's reach",
                    .where = {.point = point},
                    .hint = "see `trammel plan check`"});
}

}  // namespace

DesignModel design_model(const NominalMachine& machine, const TrackerSigma& sigma,
                         const std::vector<std::string>& effects) {
  if (!(std::isfinite(sigma.xy_mm) && sigma.xy_mm > 0 && std::isfinite(sigma.phi_rad) &&
        sigma.phi_rad > 0)) {
    throw InputError({.what = "the readings cannot be weighted",
                      .where = {.field = "sigma"},
                      .expected = "positive standard deviations of position and attitude"});
  }
  DesignModel design{nominal_model(machine.machine()), base_parameters(machine.machine(), {}),
                     sigma};
  for (const std::string& name : effects) {
    const Effect& effect = find_effect(name);
    require_effect(effect, machine.machine());
    const auto n = static_cast<int>(effect.parameters.size());
    const auto owner = static_cast<int>(design.model.effects.size());
    design.model.effects.push_back({&effect, usual_shapes(effect)});
    for (int k = 0; k < n; ++k) {
      const EffectParameter& p = effect.parameters[static_cast<std::size_t>(k)];
      if (!exists(effect, k, machine.machine())) continue;
      design.parameters.push_back(
          {FreeParameter::Kind::effect, owner, k, p.usual_max, effect.name + " " + p.name, p.unit});
    }
  }
  return design;
}

std::vector<Conditions> expected_conditions(const Plan& plan, const NominalMachine& machine) {
  const InverseResult home = machine.drives(machine.machine().home);
  if (!home.ok()) out_of_reach("home");
  Displacements at = home.l_mm, from = home.l_mm;
  std::vector<Conditions> all;
  for (const PlannedPoint& point : plan.points) {
    const InverseResult target = machine.drives(point.target);
    if (!target.ok()) out_of_reach("point " + std::to_string(point.seq));
    const PlannedMove move = planned_move(plan, point, target.l_mm, at, from);
    Conditions c;
    c.cmd_mm = at = target.l_mm;
    c.from_mm = from = move.from_mm;
    all.push_back(c);
  }
  return all;
}

Conditions conditions_at(const NominalMachine& machine, const Pose& pose, const Approach& approach,
                         double approach_mm) {
  const InverseResult at = machine.drives(pose);
  if (!at.ok()) {
    out_of_reach("(" + std::to_string(pose.x_mm) + ", " + std::to_string(pose.y_mm) + ")");
  }
  Conditions c;
  c.cmd_mm = c.from_mm = at.l_mm;
  for (int i = 0; i < machine.machine().kind->n_chains; ++i) {
    c.from_mm[i] -= approach_mm * approach[static_cast<std::size_t>(i)];
  }
  return c;
}

Eigen::MatrixXd design_jacobian(const DesignModel& design, std::span<const Conditions> readings) {
  Eigen::Vector3d weight(1 / design.sigma.xy_mm, 1 / design.sigma.xy_mm, 1 / design.sigma.phi_rad);
  for (int c = 0; c < 3; ++c) {  // what is not measured tells nothing
    if (!design.model.nominal.measured[static_cast<std::size_t>(c)]) weight[c] = 0;
  }
  Eigen::MatrixXd J(static_cast<Eigen::Index>(3 * readings.size()),
                    static_cast<Eigen::Index>(design.parameters.size()));
  Eigen::Index row = 0;
  for (const Conditions& conditions : readings) {
    const Prediction at = predict(design.model, conditions);
    TRAMMEL_ASSERT(at.ok());  // commands of the nominal robot at poses it reaches
    J.middleRows<3>(row) = derivative(design.model, design.parameters, conditions, at, weight);
    row += 3;
  }
  return J;
}

Identifiability identifiability(const DesignModel& design, const Eigen::MatrixXd& jacobian) {
  return identifiability(jacobian, scaled_parameters(design.parameters));
}

PoseUncertainty predicted_uncertainty(const DesignModel& design, const Eigen::MatrixXd& jacobian,
                                      std::span<const Pose> where) {
  Eigen::MatrixXd information = gram(jacobian);
  information.diagonal().array() += 1;
  const Cholesky factor(information);
  const NominalMachine machine(design.model.nominal);
  PoseUncertainty u;
  for (const Pose& pose : where) {
    const Conditions c = conditions_at(machine, pose, {1, 1, 1}, kComparisonApproachMm);
    const Prediction at = predict(design.model, c);
    TRAMMEL_ASSERT(at.ok());
    const Eigen::MatrixXd half =
        factor.half(derivative(design.model, design.parameters, c, at).transpose());
    const double mm = std::sqrt(half.leftCols<2>().squaredNorm()), rad = half.col(2).norm();
    u.mean_mm += mm / static_cast<double>(where.size());
    u.mean_rad += rad / static_cast<double>(where.size());
    u.max_mm = std::max(u.max_mm, mm);
    u.max_rad = std::max(u.max_rad, rad);
  }
  return u;
}

std::vector<Pose> comparison_poses(std::span<const double> orientations_rad, double half_width_mm) {
  std::vector<Pose> all;
  for (const double phi_rad : orientations_rad) {
    for (Pose pose : lattice(half_width_mm, half_width_mm / kComparisonSteps)) {
      pose.phi_rad = phi_rad;
      all.push_back(pose);
    }
  }
  return all;
}

std::vector<Pose> comparison_poses(const NominalMachine& machine,
                                   std::span<const double> orientations_rad, double half_width_mm) {
  const int n = machine.machine().kind->n_chains;
  const Pose& home = machine.machine().home;
  std::vector<Pose> all;
  for (Pose pose : comparison_poses(orientations_rad, half_width_mm)) {
    if (n < 3) pose.phi_rad = home.phi_rad;
    if (n < 2) pose.y_mm = home.y_mm;
    if (std::ranges::find(all, pose) == all.end() && reach(machine.machine(), pose).ok())
      all.push_back(pose);
  }
  return all;
}

}  // namespace trammel
