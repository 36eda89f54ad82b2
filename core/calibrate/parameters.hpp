#pragma once
// What a fit may change in a robot model, as one vector.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/calibrate/identifiability.hpp"
#include "core/model/robot_model.hpp"
#include "core/units.hpp"

namespace trammel {

/// How far an epoch's own parameters usually differ from nominal: homing on a switch again, setting
/// the tracker's frame up again. Like the tolerances of the geometry they only scale columns.
inline constexpr double kZeroToleranceMm = 0.1;
inline constexpr double kFrameToleranceMm = 0.1;
inline constexpr double kFrameToleranceRad = rad_from_deg(0.05);

/// One free parameter. The vector holds p = scale * z: z counts tolerances, so that lengths and
/// angles compare. Geometry in rad and mm; effects in the unit of their report.
struct FreeParameter {
  enum class Kind { geometry, epoch_zero, epoch_frame, effect };
  Kind kind = Kind::geometry;
  int owner = 0;  // epoch number, or place in RobotModel::effects
  int index = 0;  // geometry: of parameters_of(kind); epoch: 0..2; effect: its parameter
  double scale = 1;
  std::string name;   // "alpha_1", "l_zero_2 of epoch 2", "lead_scale k_1"
  std::string unit;   // of the report: deg, mm, …
  bool held = false;  // stays as it is: no reading follows it
};

/// The complete base of a campaign: the machine's geometry (of a 3-PRR 21), without what acts at
/// second order alone, and a zero for each drive and a frame offset for every epoch after the first
/// that `readings` know. Where phi is measured though it is no coordinate of the machine, its zero
/// in the first epoch belongs to it.
std::vector<FreeParameter> base_parameters(const Machine& nominal,
                                           const std::vector<Reading>& readings);

/// The parameters of the model's effects that are not zero-and-unused.
void add_effect_parameters(std::vector<FreeParameter>& parameters, const RobotModel& model);

/// The parameters as identifiability() and in_words() take them.
std::vector<ScaledParameter> scaled_parameters(const std::vector<FreeParameter>& parameters);

/// The model moved by `step`, in units of each parameter's scale.
RobotModel moved(RobotModel model, const std::vector<FreeParameter>& parameters,
                 const Eigen::VectorXd& step);

/// Derivative of a predicted reading by every parameter (per unit of its scale), shape (3, n); its
/// rows times `weight`.
Eigen::Matrix3Xd derivative(const RobotModel& model, const std::vector<FreeParameter>& parameters,
                            const Conditions& conditions, const Prediction& at,
                            const Eigen::Vector3d& weight = Eigen::Vector3d::Ones());

}  // namespace trammel
