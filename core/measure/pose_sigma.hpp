#pragma once
// What weights a reading: one standard deviation for each of its coordinates.

#include <Eigen/Core>
#include <limits>

#include "core/measure/reading.hpp"
#include "core/mechanism/machine.hpp"

namespace trammel {

/// x, y [mm] and phi [rad]. One tracker reads x and y alike; two axes have an instrument each.
struct PoseSigma {
  Eigen::Vector3d each = Eigen::Vector3d::Zero();

  PoseSigma() = default;
  PoseSigma(const TrackerSigma& s, double y_over_x = 1)  // NOLINT: a tracker's is one
      : each(s.xy_mm, s.xy_mm * y_over_x, s.phi_rad) {}

  /// Infinite for what is not measured: its whitened rows are then exactly 0 and weigh nothing.
  [[nodiscard]] Eigen::Vector3d of(const Coordinates& measured) const {
    Eigen::Vector3d sigma = each;
    for (int c = 0; c < 3; ++c) {
      if (!measured[static_cast<std::size_t>(c)])
        sigma[c] = std::numeric_limits<double>::infinity();
    }
    return sigma;
  }
};

}  // namespace trammel
