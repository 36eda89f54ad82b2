#pragma once
// The identified robot against the measured one: does its forward kinematics show the same errors?

#include <span>
#include <vector>

#include "core/calibrate/correction.hpp"
#include "core/statistics/summary.hpp"

namespace trammel {

/// Pose errors of one reading, (mm, mm, rad): how far the robot is from where the nominal one would
/// stand under the same command. Without compensation that is the target.
struct SimulatedError {
  Pose target;
  Eigen::Vector3d measured;
  Eigen::Vector3d simulated;
};

/// Forward-kinematics simulation: the commanded displacements through the forward kinematics of the
/// robot as `correction` believes it to be, beside the measured pose. Source: Zhang et al. 2024,
/// Sec. 3.5, Figs. 7 and 8. Rows without a measured pose are left out. Throws InputError where a
/// command is out of the believed or the nominal robot's reach, naming the seq.
/// Proof: on the robot itself simulated and measured agree to the noise (simulation_test.cpp).
std::vector<SimulatedError> simulated_errors(const Correction& correction,
                                             const NominalMachine& machine,
                                             std::span<const Reading> readings);

/// Lengths of the position errors in mm: as measured, as simulated, and of measured - simulated.
struct SimulationScore {
  Summary measured, simulated, left;
};
SimulationScore simulation_score(std::span<const SimulatedError> errors);

}  // namespace trammel
