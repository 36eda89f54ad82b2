#pragma once
// What a perfect machine reads, by the coordinates of its place that are measured.

#include <algorithm>
#include <cmath>

#include "core/mechanism/machine.hpp"
#include "core/statistics/summary.hpp"
#include "core/units.hpp"

namespace trammel {

/// Of x and y.
inline int measured_places(const Machine& machine) {
  return static_cast<int>(std::count(machine.measured.begin(), machine.measured.begin() + 2, true));
}

/// Mean length of the position error of one reading: noise_floor_mean_mm of both coordinates, sigma
/// sqrt(2 / pi) of one. Proof: verdict_test.cpp.
inline double perfect_mean_mm(int places, double sigma_xy_mm) {
  return places == 1 ? sigma_xy_mm * std::sqrt(2 / kPi) : noise_floor_mean_mm(sigma_xy_mm);
}
inline double perfect_mean_mm(const Machine& machine, double sigma_xy_mm) {
  return perfect_mean_mm(measured_places(machine), sigma_xy_mm);
}

}  // namespace trammel
