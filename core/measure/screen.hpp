#pragma once
// The screen at every door: are wires, signs, frames, units and columns right, before any number is
// fitted to them?

#include <string>
#include <vector>

#include "core/measure/reading.hpp"

namespace trammel {

/// A gross mistake by its kind; none of them is a physical effect of a sound machine.
enum class Mistake {
  drives_swapped,  // commands of two or three drives changed places
  drive_reversed,  // a rail counts backwards
  phi_offset,      // orientations are a constant off, positions stand
  frame_turned,    // the tracker's frame is turned about the origin
  frame_mirrored,  // seen from below, or an axis with the wrong sign
  scale,           // lengths in another unit
  radians,         // orientations are radians where degrees are due, or the other way about
  working_mode,    // the links stand on the other side of the platform's joints
  exchanged,       // columns of target and measured pose changed places
  shifted_rows,    // poses stand a row too early or too late
  mechanism,       // the commands are not this mechanism's for these targets
};
std::string to_string(Mistake mistake);

struct Suspicion {
  Mistake kind = Mistake::mechanism;
  std::string what;       // "drives 1 and 2 are swapped"
  std::string why;        // how far the commands are from the readings as they are, and so
  std::vector<int> seqs;  // empty: all readings
};

/// Gross mistakes of a campaign, at most two where two hypotheses fit alike; none where all is
/// sound or nothing can be said (fewer than kFewestScreened readings).
///
/// The commands c must be the inverse kinematics of the measured poses X, but for joint zeros:
///   d(H)^2 = mean over the drives of m_i^2,   m_i = 1.4826 median over readings |r - median r|,
///   r = c_i - l_i(inverse(H(X)))
/// H(X) undoes one mistake: poses turned (by the angle of the similarity of measured on target),
/// mirrored, scaled, another sign or order of the drives, the other branch of (4) in inverse.hpp, …
/// Medians, so that single wild readings and one drive's troubles decide nothing. Sound: d(none)
/// below kSoundShare of the spread of the commands: geometric errors, leads and effects of the
/// catalogue keep far below it (a lead of 25.4 for 25 moves 0.4 mm at half its travel of 50), gross
/// mistakes far above. A hypothesis is named when it brings d below a fifth; the second best beside
/// it when it fits within a factor of two, and no simpler one of the same kind does.
/// Proof: each kind put into a clean campaign is named, clean ones and those with effects are not
/// (tests/core/measure/mistakes_test.cpp).
std::vector<Suspicion> gross_mistakes(const Campaign& campaign);

inline constexpr int kFewestScreened = 6;
inline constexpr double kSoundShare = 0.06;

}  // namespace trammel
