#pragma once
// Corrections as jobs store them: the same bits come back.

#include "app/files/fields.hpp"
#include "app/job/json.hpp"
#include "core/calibrate/correction.hpp"

namespace trammel::job {

/// {"kind": "nominal" | "geometry" | "map", …}; lengths mm, angles rad, numbers in full.
Json correction_json(const Correction& correction);

/// The inverse, bit for bit. Throws InputError naming the field that is missing or wrong.
Correction read_correction(Fields correction);

/// The correction in a job's stored result ({"correction": …}).
Correction correction_of(const std::string& result_json);

}  // namespace trammel::job
