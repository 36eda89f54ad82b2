#pragma once
// Inverse kinematics for tables of poses: displacements alone, several poses side by side.

#include <array>
#include <optional>
#include <span>

#include "core/cpu_level.hpp"
#include "core/mechanism/geometry.hpp"

namespace trammel {

/// The chains seen from their rails, side by side, for many poses of one robot; the last of four is
/// empty. alpha, beta and r are in
///   ca = cos alpha,  sa = sin alpha,  k1 = r cos(beta - alpha),  k2 = r sin(beta - alpha)
struct RailFrames {
  std::array<double, 4> ca, sa, k1, k2, R_mm, S_mm, h_mm, l_zero_mm;
};
RailFrames rail_frames(const Geometry& geometry);

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
