#pragma once
// Are commands those of the nominal machine for their targets, of a correction, or neither?

#include <vector>

#include "core/measure/reading.hpp"

namespace trammel {

/// How far each reading's commands are from the nominal ones of its target; 0 out of reach.
std::vector<double> command_off_mm(const Campaign& campaign);
inline constexpr double kNominalCommandMm = 5e-3;  // encoders count finer
inline constexpr double kMostCorrectionMm = 5;     // what is more is no machine's error

/// One of few commands that are so far off that no correction asks for them.
bool single_far_command(const std::vector<double>& off_mm, std::size_t reading);

/// Places of the readings that were measured under a correction, in a campaign that does not say
/// so: their commands differ from the nominal inverse kinematics of their targets by 5 um to 5 mm,
/// and those of others do not. (Where all differ, they are commands of another model.)
std::vector<std::size_t> under_a_correction(const Campaign& campaign);

}  // namespace trammel
