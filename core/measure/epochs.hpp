#pragma once
// Whether a new homing and frame set-up moved anything.

#include <span>

#include "core/measure/reading.hpp"

namespace trammel {

/// What the deviations measured - forward(cmd) of the nominal robot tell of its epochs.
struct EpochTest {
  int later_epochs = 0;  // epochs after the first
  bool tested = false;   // false: too few readings for any answer
  bool hold = false;     // no step between epochs beyond chance
  double level = 0.01;   // chance of a step where there is none, over the three coordinates
};

/// Is there a step of the deviations from one epoch to another?
///
/// An error of the robot is a smooth function of where it stands, a new frame or new joint zeros
/// are a step at the time of the set-up. Of each coordinate (x, y, phi)
///   d_j = sum c_m m(x_j, y_j, phi_j) + sum b_i dir_i,j + sum s_e [epoch_j = e] + noise
/// m all monomials to the highest degree (4 at most) for which there are four readings a term, dir
/// the direction of approach of each rail; H0: all s_e are zero. The variance ratio of what the s_e
/// take out is compared with its limit at level / 3. The noise is what the polynomial leaves, so
/// that an error it cannot follow hides a step rather than feigns one. Readings without a pose are
/// left out. Throws InputError where a command is out of reach. Proof: false alarms, and steps of
/// 0.05 mm found, over made campaigns (epochs_test.cpp).
EpochTest test_epochs(const Mechanism& mechanism, std::span<const Reading> readings);

}  // namespace trammel
