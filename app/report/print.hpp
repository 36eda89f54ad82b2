#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/report/picture.hpp"
#include "app/report/report.hpp"
#include "app/terminal/counted.hpp"

namespace trammel::report {

/// The fields of "trammel/report/1".
nlohmann::ordered_json to_json(const Report& report);

/// "1 point", "48 points".
inline std::string points_in_words(std::size_t n) { return terminal::counted(n, "point"); }

/// What a text is written on.
struct Page {
  Glyphs glyphs = Glyphs::blocks;
  bool narrow = false;  // of 80 columns: tables of errors have mean and maximum alone
};

/// For a person: tables at most 110 columns wide, on a narrow page most at most 80.
std::string to_text(const Report& report, const Page& page);

/// The table a reader wants first, of position: unseen points before fitted ones, measured again
/// before predicted; then the contest's pick, the geometry with the named effects where they
/// explain the readings, lsq, the others in the report's order; then the most points. Never the one
/// with the least error: that would choose by what is to be judged. None before a calibration.
const ErrorTable* best_table(const Report& report);

/// The report in one sentence: what the correction of best_table does, with its 95 % interval, and
/// what the diagnosis itself doubts.
std::string verdict(const Report& report);

}  // namespace trammel::report
