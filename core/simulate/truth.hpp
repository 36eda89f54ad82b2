#pragma once
// What is hidden in the virtual robot. Everything is 0 (nothing wrong) unless stated otherwise.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/mechanism/machine.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel::simulate {

/// Errors of the drives and guides, one number a drive; those that the machine has not are 0. Of
/// the drives: what is added to the commanded displacement l [mm]. s = l - l(home), dir = sign(l -
/// from), dT = T - 20 K, t [s] since the campaign's start.
struct DriveTruth {
  Eigen::Vector3d lead_scale = Eigen::Vector3d::Zero();             // k s, 1
  Eigen::Vector3d lead_curvature_per_mm = Eigen::Vector3d::Zero();  // q s^2
  Eigen::Vector3d screw_sin_mm = Eigen::Vector3d::Zero();           // a sin(2 pi l / lead)
  Eigen::Vector3d screw_cos_mm = Eigen::Vector3d::Zero();           // b cos(2 pi l / lead)
  Eigen::Vector3d backlash_mm = Eigen::Vector3d::Zero();            // -(w / 2) dir
  Eigen::Vector3d thermal_growth_per_k = Eigen::Vector3d::Zero();   // c l dT
  Eigen::Matrix3d axis_crosstalk = Eigen::Matrix3d::Zero();         // sum of m_ij s_j, diagonal 0
  // A guide leaves its line by c s^2: of a PRR its rail, s its drive's; of a PPR its passive guide,
  // s from home along it (x along the guide of a drive in y: y errs with the square of x).
  Eigen::Vector3d guide_bow_per_mm = Eigen::Vector3d::Zero();
  // The carriage of a PPR's drive turns by k s, and its passive guide with it. A platform that is a
  // point turns too, by the sum: where phi is measured it shows.
  Eigen::Vector3d guide_yaw_rad_per_mm = Eigen::Vector3d::Zero();
  Eigen::Vector2d load_mm = Eigen::Vector2d::Zero();  // G^T (fx, fy, m), G = dX/dl
  double load_mm2 = 0;                                // m of the same
  // Outside the catalogue: what a diagnosis must not mistake for something it knows.
  Eigen::Vector3d lead_cubic_per_mm2 = Eigen::Vector3d::Zero();  // p s^3
  Eigen::Vector3d stick_slip = Eigen::Vector3d::Zero();          // -g (l - from): lost motion
  Eigen::Vector3d transient_mm = Eigen::Vector3d::Zero();        // A exp(-t / transient_tau_s)
  double transient_tau_s = 600;
  double thermal_lag_s = 0;  // the rails follow the thermometer at this distance in time
};

/// A dent or ridge of one rail: height exp(-((l - centre) / width)^2).
struct BumpTruth {
  int rail = 0;  // from 0
  double centre_mm = 0;
  double width_mm = 1;
  double height_mm = 0;
};

/// A periodic error of another period than the screw's lead.
struct HarmonicTruth {
  int rail = 0;  // from 0
  double period_mm = 5;
  double sin_mm = 0;
  double cos_mm = 0;
};

/// From this time on everything the tracker sees is moved: somebody bumped the table.
struct ShiftTruth {
  double time_s = 0;
  Pose by = {};
};

/// One homing and frame set-up.
struct EpochTruth {
  Displacements l_zero_mm = Displacements::Zero();
  Pose frame = {};
};

struct TrackerTruth {
  double sigma_xy_mm = 0;
  double sigma_phi_rad = 0;
  double correlation = 0;       // of the noise of one reading with that of the one before, [0, 1)
  Pose drift_per_h = {};        // mm/h, mm/h, rad/h
  double scale = 0;             // (x, y) *= 1 + scale
  double swirl_rad_per_mm = 0;  // outside the catalogue: an angle that grows with the radius
  double outlier_share = 0;     // probability of a wrong reading
  double outlier_mm = 0;        // length of its error, direction random
  std::vector<std::uint64_t> outliers = {};  // readings that are wrong for certain
};

/// T(t) = start + rise (1 - exp(-t / tau)): from switching on to steady.
struct TemperatureTruth {
  double start_degc = 20;
  double rise_k = 0;
  double tau_s = 2400;
};

/// How long things take.
struct MotionTruth {
  double speed_mm_s = 20;
  double settle_s = 5;
  double measure_s = 10;
};

struct Truth {
  Machine nominal;                            // what the controller believes
  std::array<ChainValues, kChains> actual{};  // what was built, joint zeros included
  bool zeroed = false;  // joint zeros set so that the commanded home is home in position (Sec. 3.3)
  double phi_zero_rad = 0;  // zeroed: the attitude that is left there
  DriveTruth drive;
  std::vector<BumpTruth> bumps;
  std::vector<HarmonicTruth> harmonics;
  std::vector<ShiftTruth> shifts;
  std::vector<EpochTruth> epochs;  // [0] is epoch 1; missing ones are as the last, none: all 0
  TrackerTruth tracker;
  TemperatureTruth temperature;
  MotionTruth motion;
  std::uint64_t seed = 1;
};

}  // namespace trammel::simulate
