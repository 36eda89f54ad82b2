#pragma once
// The equation of one chain for poses in lanes, for rails in lanes, or for one of each.

#include <cmath>
#include <cstddef>

#include "core/linear/lanes.hpp"
#include "core/mechanism/displacements.hpp"

namespace trammel {

/// A rail's frame (RailFrames), or those of several rails in lanes.
template <class T>
struct Rail {
  T ca, sa, k1, k2, R_mm, S_mm, h_mm, l_zero_mm;
};

inline Rail<double> rail(const RailFrames& f, std::size_t i) {
  return {f.ca[i], f.sa[i], f.k1[i], f.k2[i], f.R_mm[i], f.S_mm[i], f.h_mm[i], f.l_zero_mm[i]};
}

/// (4) of inverse.hpp in the rail's own frame, in mm: the arm O_C C_i and the link B_i C_i along u
/// and across it. Where the pose is out of reach `reach` and `l` are not numbers, `square` < 0.
template <class X>
struct ChainEquation {
  X arm_u, arm_n, across, square, reach, l;
};

/// At (x, y, phi), by phi's sine and cosine.
template <class F, class X>
[[gnu::always_inline]] inline ChainEquation<X> chain_equation(const Rail<F>& f, const X& x,
                                                              const X& y, const X& sine,
                                                              const X& cosine) {
  ChainEquation<X> at;
  at.arm_u = f.k1 * cosine - f.k2 * sine;
  at.arm_n = f.k2 * cosine + f.k1 * sine;
  at.across = y * f.ca - x * f.sa + at.arm_n - f.h_mm;
  at.square = (f.S_mm - at.across) * (f.S_mm + at.across);
  at.reach = each(at.square, [](double s) { return std::sqrt(s); });
  at.l = x * f.ca + y * f.sa + at.arm_u + f.R_mm - at.reach - f.l_zero_mm;
  return at;
}

}  // namespace trammel
