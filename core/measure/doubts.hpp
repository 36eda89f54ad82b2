#pragma once
// Doubts: units of sigma and temperature, clocks, copies and cells that miss.

#include <vector>

#include "core/measure/screen.hpp"

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

/// What is doubtful beside the `known` findings: nominals in place of measurements, sigmas and
/// temperatures of another unit, clocks that run backwards, duplicated rows and copies, validation
/// that judges nothing, commands of another model, cells that some readings lack. None of it is
/// looked for where a known finding puts the same columns in doubt.
/// Proof: tests/core/measure/screen_test.cpp.
std::vector<Suspicion> doubts(const Campaign& campaign, const std::vector<Suspicion>& known);

}  // namespace trammel
