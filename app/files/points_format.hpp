#pragma once
// The ways in which trackers' programs write points, as a table.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/files/points_text.hpp"

namespace trammel {

/// What a column of a points file holds.
enum class PointColumn { collection, group, name, x, y, z, time, temperature, u95, deleted, other };

/// One way of writing points. `columns` are in order; empty: the header line names them.
struct PointsFormat {
  std::string_view name;
  std::string_view what;
  std::string_view delimiters;  // one of these; ' ' is a run of blanks
  std::vector<PointColumn> columns;
};

/// sa, sa-short, leica-csv, delimited, matrix: also the order in which a file is tried.
const std::vector<PointsFormat>& points_formats();

/// How one file is written.
struct PointsColumns {
  std::string format = {};
  std::vector<PointColumn> columns = {};
  char delimiter = ',';
  std::string unit = {};  // as a header line states it
  bool header = false;    // the first line names the columns
};

/// The first format of the table that the lines have; `format` restricts it to one. A file of
/// columns without names is judged by the first of its lines that has three numbers where X, Y and
/// Z belong: the lines before may be misses. A time at the end may be missing.
/// Throws InputError that lists the formats. Proof: points_file_test.cpp.
PointsColumns recognised_columns(const std::vector<PointsLine>& lines, const std::string& format,
                                 char decimal, const std::string& file);

bool is_length(PointColumn column);
/// "x", "U(95)", …
const char* name_of(PointColumn column);

/// A number whose decimal sign is `decimal`. None: it is no number.
std::optional<double> points_number(std::string_view text, char decimal);

}  // namespace trammel
