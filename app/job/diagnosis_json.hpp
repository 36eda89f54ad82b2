#pragma once
// A diagnosis as a program reads it; text and pages are made from this.

#include "app/job/correction_json.hpp"
#include "core/diagnose/diagnose.hpp"

namespace trammel::job {

/// The fields of trammel/diagnose/1 (schemas/diagnose.schema.json). rms and noise_floor_mm are per
/// coordinate, over x and y.
Json diagnosis_json(const Diagnosis& diagnosis, const Campaign& campaign);

}  // namespace trammel::job
