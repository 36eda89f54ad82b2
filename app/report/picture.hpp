#pragma once
// Where the error is, for a person at a terminal: a map of the plane and bars of the methods.

#include <string>

#include "app/report/report.hpp"

namespace trammel::report {

/// What pictures are drawn with: block elements, or letters that every terminal has.
enum class Glyphs { blocks, ascii };

inline constexpr int kWide = 100;  // columns: pictures need no more

/// The errors of the table's points seen from above, before and after side by side on one scale: a
/// point (the mean of those that fall into one cell) is the higher or darker the larger its error,
/// in eighths of the largest. Empty when all points are at one place; a sentence where it is wider
/// than `columns`.
std::string error_map(const ErrorTable& table, Glyphs glyphs, int columns = kWide);

/// Mean position error of all methods that were judged on the points of `table`, from before to
/// the noise floor, which is marked in every bar. Narrower bars, or none, in fewer columns.
std::string method_bars(const Report& report, const ErrorTable& table, Glyphs glyphs,
                        int columns = kWide);

/// Both for the table that the verdict speaks of. Proof: picture_test.cpp.
std::string pictures(const Report& report, Glyphs glyphs);

}  // namespace trammel::report
