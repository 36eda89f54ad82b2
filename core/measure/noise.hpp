#pragma once
// How well one reading is known: from the tracker's data sheet, or from what was measured twice.

#include <optional>
#include <span>
#include <string>

#include "core/measure/reading.hpp"
#include "core/mechanism/machine.hpp"

namespace trammel {

/// Sigmas pooled over groups of repeats: readings of one command, approach, epoch and temperature.
struct PooledNoise {
  TrackerSigma sigma = {};
  int degrees_of_freedom = 0;  // of one coordinate
  int groups = 0;
  int groups_left_out = 0;  // that scatter beyond the others: a bad reading is in them
  int n_xy = 2;             // of x and y, how many are measured: xy has so many times the degrees
};

/// Pooled standard deviation of repeated readings; nothing when no pose was measured twice.
///   sigma^2 = sum_g sum_j (x_gj - mean_g)^2 / sum_g (n_g - 1),   x and y pooled
/// over the coordinates that are measured; 0 for what is not.
/// A group whose own variance is beyond that of all the others (F, kFalseGroup over all groups) is
/// left out. Readings with no move before them have the tracker's scatter, not the robot's: they
/// count only where no pose was approached twice. Proof: recovers the sigma that was put in; a
/// single repeat counts one (repeat_noise_test.cpp).
std::optional<PooledNoise> pooled_noise(std::span<const Reading> readings,
                                        const Coordinates& measured = {true, true, true});
inline constexpr double kFalseGroup = 0.001;

/// Degrees of freedom from which repeats may overrule what is stated: their sigma is then known to
/// 1 / sqrt(20) = 22 %.
inline constexpr int kEnoughRepeats = 10;
/// Level of each of the two tests of repeats against what is stated, for place and for phi.
inline constexpr double kFalseRepeats = 0.01;

/// The sigmas that weight this campaign's readings, and where they come from.
struct NoiseLevel {
  enum class Source { tracker, repeats };
  TrackerSigma sigma = {};  // per coordinate
  Source source = Source::tracker;
  int degrees_of_freedom = 0;  // of repeats; 0: as stated by the tracker, taken for known
  std::optional<TrackerSigma> stated = {};
  std::optional<PooledNoise> repeats = {};
  bool doubted = false;    // enough repeats scatter less than stated, beyond chance
  std::string words = {};  // "sigma per coordinate 0.0100 mm and 0.0040 deg, as stated …"
};

/// One noise for all commands: the sigmas that the campaign states, unless repeats of
/// kEnoughRepeats degrees of freedom exceed them beyond chance (chi^2, kFalseRepeats; place and phi
/// each for itself), then the repeats'; where they fall below, what is stated stands and is doubted
/// in words. Without a statement the repeats'. Throws InputError when a stated sigma is not
/// positive, or when there is neither. Proof: false alarms counted (repeat_noise_test.cpp).
NoiseLevel noise_level(const Campaign& campaign);

}  // namespace trammel
