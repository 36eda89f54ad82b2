#pragma once
// How well one reading is known: from the tracker's data sheet, or from what was measured twice.

#include <optional>
#include <span>
#include <string>

#include "core/measure/reading.hpp"

namespace trammel {

/// Sigmas pooled over groups of repeats: readings of one target, command, approach and epoch.
struct PooledNoise {
  TrackerSigma sigma = {};
  int degrees_of_freedom = 0;  // of phi; x and y together have twice as many
  int groups = 0;
};

/// Pooled standard deviation of repeated readings; nothing when no pose was measured twice.
///   sigma^2 = sum_g sum_j (x_gj - mean_g)^2 / sum_g (n_g - 1),   x and y pooled
/// Proof: recovers the sigma that was put in; a single repeat counts one (repeat_noise_test.cpp).
std::optional<PooledNoise> pooled_noise(std::span<const Reading> readings);

/// The sigmas that weight this campaign's readings, and where they come from.
struct NoiseLevel {
  enum class Source { tracker, repeats };
  TrackerSigma sigma = {};
  Source source = Source::tracker;
  int degrees_of_freedom = 0;  // of repeats; 0: as stated by the tracker, taken for known
  std::string words = {};      // "tracker: 0.010 mm and 0.0040 deg" …
};

/// The tracker's sigmas where the campaign states them, else those of its repeats.
/// Throws InputError when a stated sigma is not positive, or when there is neither.
NoiseLevel noise_level(const Campaign& campaign);

}  // namespace trammel
