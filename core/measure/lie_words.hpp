#pragma once
// What the lie of one column of poses on another says, in words: units, signs, turns, shifts.

#include <string>
#include <vector>

#include "core/measure/lie.hpp"
#include "core/measure/screen.hpp"

namespace trammel {

inline constexpr double kMostScaled = 0.05;                // lead and tracker scale stay below
inline constexpr double kMostTurnedRad = rad_from_deg(2);  // of a frame that was aligned by hand
inline constexpr double kMostShiftedMm = 5;                // of frame, joint zero or command

/// The unit that makes lengths so many times too large; none of them: null.
const char* unit_of(double scale);

/// "are metres", "are 1.2 times too large"
std::string unit_words(double scale);

struct LiePart {
  Mistake kind;
  std::string words;
};

/// What of the lie of `column` poses no alignment explains; empty: all is sound.
/// Proof: tests/core/measure/mistakes_test.cpp.
std::vector<LiePart> parts_of(const poses::Lie& l, const std::string& column);

}  // namespace trammel
