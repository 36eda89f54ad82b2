#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/report/picture.hpp"
#include "app/report/report.hpp"

namespace trammel::report {

/// The fields of "trammel/report/1".
nlohmann::ordered_json to_json(const Report& report);

/// For a person at a terminal, tables at most 110 columns wide; pictures drawn with `glyphs`.
std::string to_text(const Report& report, Glyphs glyphs);

/// The table a reader wants first: held-out before in-sample, position, the smallest error left;
/// none before the first calibration.
const ErrorTable* best_table(const Report& report);

/// The report in one sentence: what the best correction that was measured (else predicted) does.
std::string verdict(const Report& report);

}  // namespace trammel::report
