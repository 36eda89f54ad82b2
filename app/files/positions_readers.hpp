#pragma once
// Who reads which table of positions: one file each.

#include <string>
#include <string_view>
#include <vector>

#include "app/files/csv.hpp"
#include "app/files/points_text.hpp"
#include "app/files/positions_file.hpp"

namespace trammel {

/// A table with names and units in its header.
PositionsFile table_positions(const CsvTable& table, const PositionsOptions& options);

/// A two-dimensional calibration file of Aerotech's, known by this word of its header.
PositionsFile aerotech_positions(const PointsText& text, const std::string& name);
inline constexpr std::string_view kAerotechColumns = "Ax1CmdPos";

/// Runs of one axis as Renishaw's RTL has them, known by these words.
PositionsFile rtl_positions(const PointsText& text, const std::string& name,
                            const PositionsOptions& options);
inline constexpr std::string_view kRtlRows = "DEVIATIONS::";  // the section that holds its rows

/// The line's numbers between blanks: n of them, or any number for n = 0. Throws InputError.
std::vector<double> numbers_of(const PointsLine& line, const std::string& name, std::size_t n);

}  // namespace trammel
