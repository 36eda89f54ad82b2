#pragma once
// Doubts: units of sigma and temperature, clocks, copies and cells that miss.

#include <vector>

#include "core/measure/screen.hpp"

namespace trammel {

/// What is doubtful beside the `known` findings: nominals in place of measurements, sigmas and
/// temperatures of another unit, clocks that run backwards, duplicated rows and copies, validation
/// that judges nothing, commands of another model, cells that some readings lack. None of it is
/// looked for where a known finding puts the same columns in doubt.
/// Proof: tests/core/measure/screen_test.cpp.
std::vector<Suspicion> doubts(const Campaign& campaign, const std::vector<Suspicion>& known);

}  // namespace trammel
