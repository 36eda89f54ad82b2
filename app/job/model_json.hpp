#pragma once
// A model version as programs read it.

#include "app/job/stored_model.hpp"

namespace trammel::job {

/// {"version", "name", "parent", "identify_rms_mm", …}: a row of `model list`.
Json model_row_json(const store::Model& model);

/// The row, and "effects", "base" (geometry and epochs), "not_identified", "words".
Json model_json(const StoredModel& model, const std::string& campaign);

/// The file model/1 (schemas/model.schema.json): model_json, and the correction in full, from which
/// the same predictions follow bit for bit.
Json model_file_json(const StoredModel& model, const std::string& campaign);

}  // namespace trammel::job
