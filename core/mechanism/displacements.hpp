#pragma once
// Inverse kinematics for tables of poses: displacements alone, several poses side by side.

#include <array>
#include <optional>
#include <span>

#include "core/linear/cpu_level.hpp"
#include "core/mechanism/geometry.hpp"

namespace trammel {

/// Below this a rail does not move: a thousandth of a controller's count.
inline constexpr double kStandstillMm = 1e-6;

/// The direction in which each rail moves by `way_mm`: +1, -1, or 0 where it stands still.
inline Eigen::Vector3d directions_of(const Displacements& way_mm) {
  return way_mm.unaryExpr([](double d) {
    return d > kStandstillMm ? 1.0 : d < -kStandstillMm ? -1.0 : 0.0;
  });
}

/// The chains seen from their rails, side by side, for many poses of one robot; the last of four is
/// empty. alpha, beta and r are in
///   ca = cos alpha,  sa = sin alpha,  k1 = r cos(beta - alpha),  k2 = r sin(beta - alpha)
struct RailFrames {
  std::array<double, 4> ca, sa, k1, k2, r_mm, R_mm, S_mm, h_mm, l_zero_mm;
};
RailFrames rail_frames(const Geometry& geometry);

/// The chains at one pose, u along each rail and n across it.
struct ChainsAtPose {
  int missed = kChains;           // the first chain out of reach, from 0; kChains: none
  Displacements l_mm = {};        // (4); this and the rest where all reach
  Eigen::Vector3d link_u = {};    // the link's direction B_i C_i: cos(theta - alpha),
  Eigen::Vector3d link_n = {};    //   sin(theta - alpha)
  Eigen::Vector3d arm_u_mm = {};  // O_C C_i
  Eigen::Vector3d arm_n_mm = {};

  [[nodiscard]] bool reached() const { return missed == kChains; }
};

/// Displacements and links at X = (x, y, phi), with one sine and cosine for all chains: the
/// displacements of inverse() to 1e-11 mm, its angles to 5e-12 rad (displacements_test.cpp).
ChainsAtPose chains_at(const RailFrames& frames, const Eigen::Vector3d& X);

/// Link angles theta of B_i C_i against X, in (-pi, pi].
Eigen::Vector3d link_angles_rad(const RailFrames& frames, const ChainsAtPose& at);

/// Joint displacements (4) of inverse.hpp in each rail's own frame,
///   Q.u = x ca + y sa + k1 cos phi - k2 sin phi + R
///   Q.n = y ca - x sa + k2 cos phi + k1 sin phi - h
/// several poses side by side, sine and cosine of phi taken once a pose for all chains.
///
/// @return  the index of the first pose out of reach, whose `l_mm` and that of every other pose out
///          of reach is not a number; poses.size() when all are reached
/// Within 1e-11 mm of inverse(), whose angles are added before the cosine is taken; the same bits
/// for a pose wherever it stands in the batch, and on every level of CPU (displacements_test.cpp).
[[nodiscard]] std::size_t inverse_displacements(const RailFrames& frames,
                                                std::span<const Pose> poses,
                                                std::span<Displacements> l_mm,
                                                CpuLevel level = cpu_level());

/// The same for one pose; nothing where a chain does not reach it. No allocation.
[[nodiscard]] std::optional<Displacements> inverse_displacements(const RailFrames& frames,
                                                                 const Pose& pose);

}  // namespace trammel
