#pragma once
// What a session will measure, point by point, before anything has moved.

#include <array>
#include <string>
#include <vector>

#include "core/measure/reading.hpp"
#include "core/mechanism/displacements.hpp"
#include "core/mechanism/geometry.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

/// Direction in which each rail arrives: +1 and -1 by a move of its own, 0 as it comes.
using Approach = std::array<int, kChains>;

struct PlannedPoint {
  int seq = 0;  // order of measurement, from 1
  Pose target = {};
  ReadingSet set = ReadingSet::identify;
  Approach approach = {0, 0, 0};
  int repeat = 1;          // visit of the same target and approach, from 1
  bool reference = false;  // measured again after a resume, to see whether the set-up moved
  std::string group = {};  // what belongs together: "circle 1", "rail 2"; else empty
};

struct Plan {
  std::string name;
  double approach_mm = 5;  // length of the last move of a rail with a direction
  std::vector<PlannedPoint> points;
};

/// Where each rail goes for one point. `from` is where its last move began, as in Conditions.
struct PlannedMove {
  Displacements pre_mm = {};   // where the last move of the stage begins
  Displacements from_mm = {};  // per rail: pre_mm, or the start of an earlier move if it stays
  bool pre_position = false;   // a move to pre_mm comes first
};

/// The last move to `cmd_mm` from a stage that stands at `at_mm`, whose rails' last moves began at
/// `at_from_mm`.
///
/// Rail i with direction d: pre = cmd - d * approach_mm; else pre = at. A rail that has nowhere to
/// go (|cmd - pre| <= kStandstillMm) keeps the direction of its last move.
/// Proof: build_test.cpp.
PlannedMove planned_move(const Plan& plan, const PlannedPoint& point, const Displacements& cmd_mm,
                         const Displacements& at_mm, const Displacements& at_from_mm);

/// Throws InputError that names the point: no points, seq not 1, 2, …, a target that is not finite,
/// a direction other than -1, 0, 1, a repeat below 1, an approach of no length.
void validate(const Plan& plan);

}  // namespace trammel
