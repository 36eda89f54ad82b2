#pragma once
// Pose accuracy and repeatability by ISO 9283:1998, planar: z dropped, the angle c is phi.
//
// The formulas are general knowledge of the standard: to be checked against the standard itself
// before anyone certifies by them.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/judge/iso_symbol.hpp"
#include "core/measure/reading.hpp"

namespace trammel {

/// One pose, visited n times from one direction under one set-up.
struct PoseVisits {
  Pose target;
  std::array<int, kChains> direction = {};  // sign of each rail's last move
  int epoch = 1;
  std::vector<Eigen::Vector3d> deviation;     // attained less target: mm, mm, rad
  std::vector<std::optional<double>> time_s;  // of the same visits
};

/// Readings that share target, direction of approach and epoch, in the order of their first visit;
/// visits in the order of seq. Readings without a measured pose are left out.
std::vector<PoseVisits> pose_visits(std::span<const Reading> readings);

/// What n visits of one pose show. With m the mean deviation and l_j = |p_j - m| in the plane:
///   AP_p = |m|, AP_x = m_x, AP_y = m_y, AP_c = m_phi
///   RP_l = mean l + 3 S_l, S_l^2 = sum (l_j - mean l)^2 / (n - 1);  RP_c = 3 S_phi
struct PoseAccuracy {
  int n = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double AP_p_mm = 0;
  double RP_l_mm = 0;   // n >= 2
  double RP_c_rad = 0;  // n >= 2
};
PoseAccuracy pose_accuracy(std::span<const Eigen::Vector3d> deviation);

/// RP_l of one reflector in space: the same formula with l_j = |p_j - m| of three coordinates.
/// At least two points. Proof: iso9283_test.cpp.
double point_repeatability_mm(std::span<const Eigen::Vector3d> points_mm);

inline constexpr int kVisitsOfTheStandard = 30;
inline constexpr int kLeastVisits = 5;  // below it a spread of visits has no figure worth a name
inline constexpr int kPosesOfTheStandard = 5;
inline constexpr double kDriftHoursOfTheStandard = 8;

struct Iso9283 {
  int n_poses = 0;      // poses with their direction and epoch
  int least_n = 0;      // visits of the pose visited least
  int most_n = 0;       // visits of the pose visited most
  double mean_mm = 0;   // mean positional deviation |attained - target| over all visits
  double mean_rad = 0;  // of the attitude
  /// AP_p, AP_x, AP_y, AP_c, RP_l, RP_c, vAP_p, vAP_c, dAP_p, dRP_l: the largest over the poses
  /// that were visited often enough (AP_x, AP_y, AP_c with their sign), or refused in words.
  std::vector<IsoSymbol> symbols;
};

/// The standard's symbols for these readings.
///
/// Given plainly for n >= 30 visits and five poses; with n in the name and the reserve in words
/// from kLeastVisits on; refused below. vAP = largest |m_h - m_k| between directions h, k of one
/// pose in one epoch: needs two directions. Drift: visits of a pose in series of ten (five where
/// there are fewer than twenty), dAP_p = max |AP_p(series) - AP_p(first)|, dRP_l likewise: needs
/// two series and recorded times. `sigma` gives floors. Throws InputError when no reading has a
/// measured pose. Proof: iso9283_test.cpp, golden numbers by scripts/make_golden_iso.py.
Iso9283 iso9283(std::span<const Reading> readings, const std::optional<TrackerSigma>& sigma = {});

}  // namespace trammel
