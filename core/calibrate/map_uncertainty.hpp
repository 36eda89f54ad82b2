#pragma once
// How well a map of joint errors knows the pose: any map that is linear in its samples.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "core/calibrate/joint_map.hpp"
#include "core/measure/reading.hpp"
#include "core/mechanism/nominal_machine.hpp"

namespace trammel {

/// The error of the pose as a random field, one process a coordinate (x, y, and phi times
/// kPhiLengthOfFieldMm), and what the map makes of its samples.
struct MapUncertainty {
  JointMap map;
  std::vector<JointSample> samples;  // what the map was made of
  std::vector<Eigen::Matrix3d> J_V;  // at each sample
  GpMap field;
  Eigen::Vector3d sigma_mm = {};                   // of a reading, in the field's coordinates
  std::array<Eigen::MatrixXd, 3> covariance = {};  // of the samples, noise included
  Eigen::MatrixXd network = {};  // rbf: from samples to weights, shape (neurons + 1, samples)
};
inline constexpr double kPhiLengthOfFieldMm = 100;  // the paper's platform: any length serves

/// A field of so many samples takes a second or two to fit.
inline constexpr std::size_t kMostFieldSamples = 1000;

/// Of a map made of `samples`, taken under the commands of `readings`, in their order. The field's
/// length, size and noise are those of largest likelihood (gp.hpp). Throws InputError as fit_gp, or
/// where the nominal robot cannot reach a command.
MapUncertainty map_uncertainty(const JointMap& map, const NominalMachine& machine,
                               std::span<const JointSample> samples,
                               std::span<const Reading> readings, const TrackerSigma& sigma);

/// Covariance of where the corrected robot stands, diagonal, shape (3): mm^2, mm^2, rad^2; without
/// a reading's noise. A map gives joint i the error sum_k w_ik(p) e_ik, so that the pose is off by
///   d(p) - sum_k M_k d_k,   M_k = J_V(p) diag(w_k(p)) J_V,k^-1,   d_k: error of the pose at sample
///   k
/// and with processes d_c of covariance k_c, noise n_c and mean m_c (kriging of a given predictor,
/// Cressie 1993, Sec. 3.2)
///   u_c^2 = k_c(p, p) - 2 sum_k M_k,cc k_c(p, p_k) + sum_b m_cb' (K_b + n_b^2 I) m_cb
///           + (m_c - sum_kb M_k,cb m_b)^2 + max(0, n_c^2 - sigma_c^2)
/// the last what no place explains beyond a reading's noise. `J_V`: at the target.
/// Proof: coverage by simulation (uncertainty_test.cpp).
Eigen::Vector3d pose_variance(const MapUncertainty& of, Place at, const Eigen::Matrix3d& J_V);

}  // namespace trammel
