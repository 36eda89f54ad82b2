#pragma once
// Spatially blocked cross-validation of any correction.

#include <functional>
#include <span>
#include <vector>

#include "core/calibrate/correction.hpp"

namespace trammel::job {

/// Fits the readings of a campaign.
using Fit = std::function<Correction(const Campaign&)>;

/// Where each of `rows` would have gone under a correction fitted without its block, in their
/// order. Throws InputError as the fit, or when a corrected target is out of reach.
std::vector<Pose> held_out_poses(const Fit& fit, const Campaign& campaign,
                                 std::span<const Reading> rows, const std::vector<int>& block);

}  // namespace trammel::job
