#pragma once
// Gross mistakes: one of them explains a campaign that otherwise makes no sense.

#include <optional>
#include <vector>

#include "core/measure/screen.hpp"

namespace trammel {

/// Gross mistakes of a campaign, at most two where two hypotheses fit alike; none where all is
/// sound or nothing can be said (fewer than kFewestScreened measured readings).
///
/// Three relations of target T, measured pose M and command c hold in a sound campaign, each within
/// what machining, effects and a common frame allow:
///   M = s R(turn) T + t, phi_M = slope phi_T + offset        similarity, straight or mirrored
///   c = l(T) + const,    c = l(M) + const                    (4) of inverse.hpp, const: joint
///   zeros
/// A hypothesis undoes one mistake in one of the three columns, and is named when it brings the
/// relation that is broken below a fifth of what it was, with what is left below kSoundShare of the
/// spread; the second best beside it when it fits within a factor of two. Distances are robust: the
/// 75th percentile of |r| over 1.1503 (that of |N(0, 1)|), so that a quarter of wild readings
/// decides nothing, nor that half the rows of a campaign with repeats stay equal when shifted.
/// Limits: kMostTurnedRad, kMostShiftedMm and kMostScaled (lie_words.hpp) are far beyond what
/// machining and alignment leave and what a model of the geometry takes up: a lead of 25.4 for 25
/// scales by 1.016. Proof: tests/core/measure/screen_test.cpp. `last_resort`: with deviations in
/// micrometres, which fit whatever is smooth.
std::vector<Suspicion> gross_mistakes_of_all(const Campaign& campaign, bool last_resort = false);

/// The same, and where no mistake of all readings is named those of a part of them: one set, one
/// epoch, or the rows that lie five times as far from their targets as the others (two exports in
/// one file). An epoch's own frame is no mistake. Proof: tests/core/measure/mistakes_test.cpp.
std::vector<Suspicion> gross_mistakes(const Campaign& campaign);

/// The same from one reading on, where a session has just begun: mistakes without a number of their
/// own (metres, inches, a quarter turn, a mirrored axis, swapped or reversed drives, deviations),
/// by the largest distance over the readings, with joint zeros known. Named where it falls below a
/// tenth and kCloseMm. Proof: tests/core/measure/screen_test.cpp.
std::vector<Suspicion> gross_mistakes_of_few(const Campaign& campaign);

/// The campaign with what is not measured, or no coordinate of its machine (phi of an XY stage), at
/// its targets: nothing is held against either.
Campaign completed(const Campaign& campaign);

inline constexpr double kCloseMm = 3;
inline constexpr int kFewestScreened = 6;
inline constexpr double kSoundShare = 0.06;

/// How a tracker's frame lies in the robot's: measured = R(turn) pose + shift.
struct FrameMove {
  double turn_rad = 0;
  double shift_x_mm = 0;
  double shift_y_mm = 0;
};

/// The frame of the measured poses by a robust rigid fit on the targets; none with fewer than
/// kFewestScreened readings, or where the poses are no turned and shifted targets.
std::optional<FrameMove> fitted_frame(const Campaign& campaign);

/// `pose` as it is in the robot's frame. Proof: tests/core/measure/screen_test.cpp.
Pose in_robot_frame(const FrameMove& frame, const Pose& pose);

}  // namespace trammel
