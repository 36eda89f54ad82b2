#pragma once
// What doubts() looks for, a file each. Proof: tests/core/measure/screen_test.cpp,
// tests/core/measure/mistakes_test.cpp.

#include <vector>

#include "core/measure/screen.hpp"

namespace trammel {

/// Nominals in place of what was measured, and the two columns in each other's place: true where
/// one is found, and scatter and copies say nothing.
bool add_doubts_of_digits(const Campaign& campaign, std::vector<Suspicion>& found);
/// Readings that stand twice, and validation readings that are copies of fitted ones: one target
/// and one pose to the last digit, where digits are finer than noise.
void add_doubts_of_copies(const Campaign& campaign, std::vector<Suspicion>& found);
/// Of the stated sigma's unit; orientations in radians (gross) where their scatter alone can tell.
void add_doubts_of_sigma(const Campaign& campaign, std::vector<Suspicion>& found);
/// Of times and temperatures.
void add_doubts_of_cells(const Campaign& campaign, std::vector<Suspicion>& found);

}  // namespace trammel
