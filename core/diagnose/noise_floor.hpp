#pragma once
// Step 1 of a diagnosis: what a perfect model would leave of a reading, and which readings are no
// measurements at all. Called in the order in which they stand here.

#include <optional>
#include <vector>

#include "core/diagnose/work.hpp"

namespace trammel {

/// Whose word on the noise is taken first.
void first_noise(Work& w);

/// Readings that are wrong whatever the model is: no fit begins with them.
void drop_certain_readings(Work& w, const std::vector<Suspicion>& found);

/// Far readings of noise with heavy tails are noise: they are drawn in, and leave the verdict
/// alone. Where the far ones are structure (a bump, a stretch of time), exchanging the readings
/// does not show it again, and nothing is drawn in.
void settle_tails(Work& w);

/// Single bad readings first, where the tails are normal: four outliers must not become seven
/// effects.
void drop_bad_readings(Work& w);

/// White residuals of another size than was stated are not structure: scale, and go on.
void settle_noise(Work& w);

/// What is left is kMuchLarger of the noise that tracker or repeats state, and no re-approach of a
/// target repeats as badly: then it is no noise of theirs, however white it looks, but something
/// that is wrong with the readings (a corner of the plane that is millimetres off).
std::optional<Finding> unsupported_noise(const Work& w);
inline constexpr double kMuchLarger = 10;

/// Noise that is correlated in time is still noise: successive readings are made independent.
void settle_correlation(Work& w, bool known = false);

}  // namespace trammel
