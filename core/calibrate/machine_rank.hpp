#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/calibrate/identifiability.hpp"
#include "core/mechanism/machine_kinematics.hpp"

namespace trammel {

/// What readings of the measured coordinates can tell about a machine's parameters, however
/// precise.
struct MachineRank {
  std::string orientation;  // "constant", "varied"
  std::string parameters;   // "all", "the paper's"
  Identifiability of;
};

/// Rank and null space of J_e in what is measured, stacked over 80 poses strewn about home within a
/// quarter of the shortest stroke, at home's orientation and with it varied (no more than 20 deg);
/// for a kind with parameters that complete it, with and without these.
///
/// A column below 1e-12 of the largest is zero, in tolerances: its parameter acts at second order
/// alone. A direction counts from 1e-9 of the largest singular value on: between 1e-14 of rounding
/// and what a stroke of 5 mm still shows of a guide skewed by 1 deg.
/// Proof: the ranks of an independent program (machine_rank_test.cpp).
std::vector<MachineRank> machine_ranks(const Machine& machine);

}  // namespace trammel
