#pragma once
// Whether a new homing and frame set-up moved anything, and by how much.

#include <map>
#include <span>
#include <vector>

#include "core/measure/reading.hpp"
#include "core/mechanism/nominal_machine.hpp"

namespace trammel {

/// What a homing and frame set-up changed against the first epoch.
struct EpochShift {
  Displacements l_zero_mm = Displacements::Zero();
  Pose frame;  // reading = frame shift of the pose: turned by phi about O_A, then moved by (x, y)
};
using EpochShifts = std::map<int, EpochShift>;  // an epoch that is not listed has no shift
EpochShift shift_of(const EpochShifts& shifts, int epoch);

/// `pose` as a tracker reads it whose frame is shifted by `frame`; and back.
Pose in_frame(const Pose& frame, const Pose& pose);
Pose out_of_frame(const Pose& frame, const Pose& pose);

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
EpochTest test_epochs(const NominalMachine& machine, std::span<const Reading> readings);

/// Shift of each epoch after the first, beside the smooth error of test_epochs, for methods without
/// a model of their own:
///   d_j = smooth error + J_V l_zero_e + (x_e - y_j phi_e, y_e + x_j phi_e, phi_e) + noise
/// by least squares, each coordinate weighted by what smooth error and shifts leave of it. Six
/// values an epoch are more than one orientation tells apart: between those that fit alike the
/// weak prior of a set-up decides (joint zeros 0.1 mm, frame 1 mm and 10 mrad). Throws as
/// test_epochs. Proof: shifts put into made campaigns, and maps made under them (epochs_test.cpp,
/// epochs_of_methods_test.cpp).
EpochShifts epoch_shifts(const NominalMachine& machine, std::span<const Reading> readings);

/// The readings as they would have been in the first epoch: out of their frames, from their joint
/// zeros.
std::vector<Reading> without_shifts(std::span<const Reading> readings, const EpochShifts& shifts);

}  // namespace trammel
