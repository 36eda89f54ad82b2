#include "app/files/points_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/files/numbers.hpp"
#include "core/error.hpp"

namespace trammel {

namespace {

/// Columns that a header line names, by how the name begins (runs of blanks are one).
struct NamedColumn {
  std::string_view begins;
  PointColumn column;
};
constexpr std::array<NamedColumn, 7> kNamedColumns = {{{"X [", PointColumn::x},
                                                       {"Y [", PointColumn::y},
                                                       {"Z [", PointColumn::z},
                                                       {"U(95) [", PointColumn::u95},
                                                       {"Temperature [", PointColumn::temperature},
                                                       {"Time Stamp", PointColumn::time},
                                                       {"Delete", PointColumn::deleted}}};

constexpr std::size_t kLinesTried = 100;  // to recognise a format: the first ones may be misses

/// The columns by their names, where this line names X, Y and Z.
std::optional<PointsColumns> by_header(const PointsLine& line, char delimiter) {
  PointsColumns found{.delimiter = delimiter, .header = true};
  for (const PointsCell& cell : points_cells(line.text, found.delimiter)) {
    const std::string title = single_blanks(cell.text);
    const auto known =
        std::find_if(kNamedColumns.begin(), kNamedColumns.end(),
                     [&](const NamedColumn& c) { return title.starts_with(c.begins); });
    found.columns.push_back(known != kNamedColumns.end() ? known->column : PointColumn::other);
    if (found.columns.back() == PointColumn::x) found.unit = title.substr(3, title.find(']') - 3);
  }
  for (const PointColumn needed : {PointColumn::x, PointColumn::y, PointColumn::z}) {
    if (std::find(found.columns.begin(), found.columns.end(), needed) == found.columns.end()) {
      return std::nullopt;
    }
  }
  return found;
}

/// The columns of `format`, where `line` has them under one of its delimiters.
std::optional<PointsColumns> by_numbers(const PointsFormat& format, const PointsLine& line,
                                        char decimal) {
  for (const char delimiter : format.delimiters) {
    const auto cells = points_cells(line.text, delimiter);
    const std::size_t n = format.columns.size();
    const bool timed = format.columns.back() == PointColumn::time;
    if (cells.size() != n && !(timed && cells.size() + 1 == n)) continue;
    bool numbers = true;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      numbers = numbers && (!is_length(format.columns[k]) || points_number(cells[k].text, decimal));
    }
    // A first column with a fraction is a coordinate: the line has one number too many.
    const auto first = points_number(cells.front().text, decimal);
    const bool named = format.columns.front() == PointColumn::name;
    if (!numbers || (named && first && *first != std::floor(*first))) continue;
    const auto end = format.columns.begin() + static_cast<std::ptrdiff_t>(cells.size());
    return PointsColumns{.columns = {format.columns.begin(), end}, .delimiter = delimiter};
  }
  return std::nullopt;
}

std::optional<PointsColumns> columns_as(const PointsFormat& format,
                                        const std::vector<PointsLine>& lines, char decimal) {
  if (format.columns.empty()) {
    for (const char delimiter : format.delimiters) {
      if (auto found = by_header(lines.front(), delimiter)) return found;
    }
    return std::nullopt;
  }
  for (std::size_t k = 0; k < std::min(kLinesTried, lines.size()); ++k) {
    if (auto found = by_numbers(format, lines[k], decimal)) return found;
  }
  return std::nullopt;
}

}  // namespace

const std::vector<PointsFormat>& points_formats() {
  using enum PointColumn;
  static const std::vector<PointsFormat> formats = {
      {"leica-csv", "separated under a header with X [mm], Y [mm], Z [mm]", ",;\t", {}},
      {"sa",
       "SpatialAnalyzer: collection, group, point, X, Y, Z, time",
       ",",
       {collection, group, name, x, y, z, time}},
      {"sa-short", "point, X, Y, Z with commas", ",", {name, x, y, z}},
      {"delimited", "point X Y Z with ; or tabs or blanks", ";\t ", {name, x, y, z}},
      {"matrix", "X Y Z and nothing else", " \t;,", {x, y, z}},
  };
  return formats;
}

PointsColumns recognised_columns(const std::vector<PointsLine>& lines, const std::string& format,
                                 char decimal, const std::string& file) {
  std::string names;
  for (const PointsFormat& known : points_formats()) {
    names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", known.name, known.what);
    if (!format.empty() && format != known.name) continue;
    if (auto found = columns_as(known, lines, decimal)) {
      found->format = known.name;
      return *found;
    }
  }
  const std::string& first = lines.front().text;
  const bool comma = decimal == '.' && first.find(';') != std::string::npos;
  throw InputError({.what = format.empty() ? "no known format of tracker points"
                                           : "the points are not in the format " + format,
                    .where = {.file = file, .line = lines.front().number},
                    .got = "'" + first.substr(0, 80) + "'",
                    .expected = names,
                    .hint = comma ? "is a comma the decimal sign?" : ""});
}

bool is_length(PointColumn column) {
  return column == PointColumn::x || column == PointColumn::y || column == PointColumn::z;
}

const char* name_of(PointColumn column) {
  constexpr std::array<const char*, 11> kNames = {
      "collection", "group", "name", "x", "y", "z", "time", "temperature", "U(95)", "Delete", ""};
  return kNames[static_cast<std::size_t>(column)];
}

std::optional<double> points_number(std::string_view text, char decimal) {
  if (decimal == '.') return parse_number(text);
  if (text.find('.') != std::string_view::npos) return std::nullopt;
  std::string with_point(text);
  std::replace(with_point.begin(), with_point.end(), decimal, '.');
  return parse_number(with_point);
}

}  // namespace trammel
