#pragma once
// How far the gap between simulation and measurement shrinks, model by model.

#include <span>

#include "core/diagnose/diagnose.hpp"

namespace trammel {

/// Fills `diagnosis.gap`: nominal, geometry, and every effect added in turn (the largest first),
/// each refitted to `fitted`, judged on `fitted` and on the campaign's validation readings; and
/// `diagnosis.gap_tried`, the same of the effects that were tried in vain.
///
/// share closed = 1 - (rms_after^2 - s^2) / (rms_before^2 - s^2), s the noise of one coordinate; 95
/// % interval by a paired bootstrap over readings.
void measure_gap(const Campaign& campaign, std::span<const Reading> fitted, const GeometryFit& base,
                 Diagnosis& diagnosis);

}  // namespace trammel
