#pragma once
// What readings that nobody has taken yet would tell: a plan seen as a design of an experiment.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/calibrate/identifiability.hpp"
#include "core/calibrate/parameters.hpp"
#include "core/mechanism/nominal_machine.hpp"
#include "core/plan/plan.hpp"

namespace trammel {

/// What is to be identified: the complete base of one epoch, and named effects, at the nominal
/// robot.
struct DesignModel {
  RobotModel model;
  std::vector<FreeParameter> parameters;
  TrackerSigma sigma;
};

/// Throws InputError for sigmas that are not positive and for an effect that the machine has not
/// (require_effect), NotFoundError for an unknown one.
DesignModel design_model(const NominalMachine& machine, const TrackerSigma& sigma,
                         const std::vector<std::string>& effects = {});

/// Conditions of each reading a plan would bring: the nominal commands, and where each last move
/// began (the stage starts at home). Throws InputError naming a point out of reach.
std::vector<Conditions> expected_conditions(const Plan& plan, const NominalMachine& machine);

/// Conditions of a pose, reached by moves of `approach_mm` in the direction `approach`.
Conditions conditions_at(const NominalMachine& machine, const Pose& pose, const Approach& approach,
                         double approach_mm);

/// d reading / d z over the tracker's sigma (z in tolerances), shape (3 readings, parameters). An
/// effect that needs a temperature or a time says nothing here: plans do not set them.
Eigen::MatrixXd design_jacobian(const DesignModel& design, std::span<const Conditions> readings);

Identifiability identifiability(const DesignModel& design, const Eigen::MatrixXd& jacobian);

/// Standard deviation of the predicted pose over a set of places, after the fit.
struct PoseUncertainty {
  double mean_mm = 0;  // of sqrt(var x + var y)
  double max_mm = 0;
  double mean_rad = 0;
  double max_rad = 0;
};

/// u^2(X*) = J* (I + J' J)^-1 J*': tolerances are the prior, so that what the readings do not tell
/// is known as well as the machining and no worse (GUM; J of design_jacobian). Every place is
/// reached in the + direction of all rails. Proof: the scatter of simulated fits
/// (optimal_plan_test.cpp).
PoseUncertainty predicted_uncertainty(const DesignModel& design, const Eigen::MatrixXd& jacobian,
                                      std::span<const Pose> where);

/// Poses of the square of +-half_width every quarter of it, at these orientations: where plans are
/// compared. The paper's is +-100 mm.
std::vector<Pose> comparison_poses(std::span<const double> orientations_rad,
                                   double half_width_mm = 100);
/// The same of those coordinates that the machine moves, where it reaches: the others at home.
std::vector<Pose> comparison_poses(const NominalMachine& machine,
                                   std::span<const double> orientations_rad, double half_width_mm);

}  // namespace trammel
