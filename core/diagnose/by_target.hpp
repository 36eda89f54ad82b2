#pragma once
// What runs in both directions say at each target by itself, whatever the model is.

#include <span>
#include <string>
#include <vector>

#include "core/measure/reading.hpp"
#include "core/mechanism/machine.hpp"

namespace trammel {

/// One axis at one target, over runs from both sides.
struct AtTarget {
  int chain = 0;         // from 0
  double target_mm = 0;  // of the coordinate that the axis moves
  int readings = 0;
  double reversal_mm = 0, reversal_std_mm = 0;  // in + direction less in - direction
  double drift_mm = 0, drift_std_mm = 0;        // from one run to the next
};

/// Least squares at each target of a point platform that was reached kFewestRuns times from either
/// side and by this axis alone or with others,
///   d = mean + (B / 2) dir + v run + noise,   run = 0, 1, … on either side
/// with standard deviations from what is left. No other machine has an axis for a coordinate.
/// Proof: tests/core/diagnose/machines_test.cpp.
std::vector<AtTarget> reversals_by_target(const Machine& machine,
                                          std::span<const Reading> readings);
inline constexpr int kFewestRuns = 3;

/// "x axis at 15 mm: reversal +5.20 +- 0.24 um, drift -0.50 +- 0.04 um a run (20 readings)"
std::string in_words(const AtTarget& at, const Machine& machine);

}  // namespace trammel
