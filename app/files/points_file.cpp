#include "app/files/points_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "app/files/files.hpp"
#include "app/files/numbers.hpp"
#include "app/files/points_format.hpp"
#include "app/files/points_text.hpp"
#include "core/error.hpp"
#include "core/measure/point_outliers.hpp"

namespace trammel {

namespace {

struct LengthUnit {
  std::string_view name;
  double mm;
};
constexpr std::array<LengthUnit, 8> kUnits = {{{"mm", 1},
                                               {"millimeters", 1},
                                               {"m", 1000},
                                               {"meters", 1000},
                                               {"um", 0.001},
                                               {"in", 25.4},
                                               {"inches", 25.4},
                                               {"inch", 25.4}}};

/// Programs write the same unit with a capital or without.
std::string in_small_letters(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

class PointsReader {
 public:
  PointsReader(PointsText text, const std::string& name, const PointsOptions& options)
      : text_(std::move(text)), options_(options) {
    file_.name = name;
    file_.code_page_1252 = text_.code_page_1252;
  }

  PointsFile read() {
    read_comments();
    if (text_.lines.empty()) refuse_file("the file holds no points", "lines with X, Y and Z");
    is_ = recognised_columns(text_.lines, options_.format, options_.decimal, file_.name);
    if (is_.header) next_ = 1;
    settle_unit();
    for (; next_ < text_.lines.size(); ++next_) add_row(text_.lines[next_]);
    if (file_.rows.empty()) refuse_file("there are no points", "lines with X, Y and Z");
    std::vector<ClockLine> clocks;
    for (const PointRow& row : file_.rows) {
      if (row.clock) clocks.push_back({row.line, *row.clock});
    }
    file_.dates = date_reading(clocks, options_.date, file_.name);
    return std::move(file_);
  }

 private:
  [[noreturn]] void refuse_file(const std::string& what, const std::string& expected,
                                const std::string& hint = "") const {
    throw InputError(
        {.what = what, .where = {.file = file_.name}, .expected = expected, .hint = hint});
  }

  [[noreturn]] void refuse_at(const PointsLine& line, std::size_t k, const std::string& what,
                              const std::string& expected, const std::string& hint = "") const {
    const auto cells = cells_of(line);
    const bool there = k < cells.size();
    throw InputError({.what = what,
                      .where = {.file = file_.name,
                                .line = line.number,
                                .column = there ? cells[k].column : 0,
                                .field = k < is_.columns.size() ? name_of(is_.columns[k]) : ""},
                      .got = there ? "'" + std::string(cells[k].text) + "'" : std::string(),
                      .expected = expected,
                      .hint = hint});
  }

  [[nodiscard]] std::vector<PointsCell> cells_of(const PointsLine& line) const {
    return points_cells(line.text, is_.delimiter);
  }

  /// What SpatialAnalyzer says above the points.
  void read_comments() {
    for (const std::string& comment : text_.comments) {
      if (const auto at = comment.find("Coordinate Frame "); at != std::string::npos) {
        file_.frame = comment.substr(at + 17);
        std::erase(file_.frame, '\'');
      }
      if (comment.starts_with("SpatialAnalyzer")) file_.program = comment;
      if (!comment.starts_with("AXES")) continue;
      if (comment.find("CARTESIAN") == std::string::npos) {
        refuse_file("the axes are not cartesian: " + comment, "X, Y, Z");
      }
      const auto open = comment.rfind('('), close = comment.rfind(')');
      if (open < close && close != std::string::npos) {
        file_.unit = comment.substr(open + 1, close - open - 1);
      }
    }
  }

  void settle_unit() {
    file_.format = is_.format;
    if (!is_.unit.empty()) file_.unit = is_.unit;
    file_.unit_stated = !file_.unit.empty();
    if (file_.unit_stated && !options_.unit.empty() &&
        mm_of_unit(file_.unit) != mm_of_unit(options_.unit)) {
      refuse_file("the file states its unit as " + file_.unit, options_.unit);
    }
    if (!file_.unit_stated) file_.unit = options_.unit.empty() ? "mm" : options_.unit;
    unit_mm_ = mm_of_unit(file_.unit);
  }

  [[nodiscard]] double number_of(const PointsLine& line, std::size_t k,
                                 std::string_view text) const {
    const auto value = points_number(text, options_.decimal);
    if (!value) {
      refuse_at(line, k, "this is no number", fmt::format("a number with '{}'", options_.decimal),
                points_number(text, options_.decimal == '.' ? ',' : '.')
                    ? "is a comma the decimal sign? --decimal says so, in a layout \"decimal\""
                : next_ == 0 ? "a line above the points begins with //, # or %"
                             : "");
    }
    return *value;
  }

  void add_row(const PointsLine& line) {
    const auto cells = cells_of(line);
    const std::size_t n = is_.columns.size();
    if (cells.size() > n) refuse_at(line, n, "more fields than columns", std::to_string(n));
    PointRow row;
    row.line = line.number;
    row.raw = line.text;
    int n_lengths = 0;
    bool deleted = false;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      if (cells[k].text.empty()) continue;
      if (is_.columns[k] == PointColumn::deleted) deleted = is_true(cells[k].text);
      n_lengths += is_length(is_.columns[k]) ? 1 : 0;
      take_cell(line, k, cells[k].text, row);
    }
    if (deleted && options_.misses.contains(Miss::deleted)) {
      row.miss = Miss::deleted;
    } else if (n_lengths < 3) {
      row.miss = Miss::empty;
      if (!options_.misses.contains(Miss::empty)) {
        refuse_at(line, cells.size(), "a coordinate is empty", "X, Y and Z",
                  "a tracker that writes its misses so: name \"empty\" among the misses");
      }
    } else if (cut_short(line, cells.size())) {
      refuse_at(line, cells.size(), "a field is missing", std::to_string(n) + " fields");
    } else if (is_miss(row.at_mm) && options_.misses.contains(Miss::zero)) {
      row.miss = Miss::zero;
    }
    file_.rows.push_back(std::move(row));
  }

  /// Empty fields at the end are no harm where the header says that they are fields.
  [[nodiscard]] bool cut_short(const PointsLine& line, std::size_t n_cells) const {
    if (!is_.header) return n_cells < is_.columns.size();
    const auto delimiters = std::count(line.text.begin(), line.text.end(), is_.delimiter);
    return static_cast<std::size_t>(delimiters) + 1 < is_.columns.size();
  }

  static bool is_true(std::string_view text) {
    return text == "TRUE" || text == "True" || text == "true";
  }

  void take_cell(const PointsLine& line, std::size_t k, std::string_view text,
                 PointRow& row) const {
    switch (is_.columns[k]) {
      case PointColumn::x:
        row.at_mm.x() = number_of(line, k, text) * unit_mm_;
        break;
      case PointColumn::y:
        row.at_mm.y() = number_of(line, k, text) * unit_mm_;
        break;
      case PointColumn::z:
        row.at_mm.z() = number_of(line, k, text) * unit_mm_;
        break;
      case PointColumn::group:
        row.group = text;
        break;
      case PointColumn::name:
        row.name = text;
        break;
      case PointColumn::temperature:
        row.temp_degc = number_of(line, k, text);
        break;
      case PointColumn::u95:
        row.u95_mm = number_of(line, k, text) * unit_mm_;
        break;
      case PointColumn::time:
        row.clock = parse_clock(text);
        if (!row.clock) refuse_at(line, k, "this is no time", "as in 02/12/25 16:40:57");
        break;
      case PointColumn::deleted:
      case PointColumn::collection:
      case PointColumn::other:
        break;
    }
  }

  PointsText text_;
  PointsOptions options_;
  PointsFile file_;
  PointsColumns is_;
  double unit_mm_ = 1;
  std::size_t next_ = 0;
};

}  // namespace

double mm_of_unit(std::string_view unit) {
  for (const LengthUnit& known : kUnits) {
    if (known.name == in_small_letters(unit)) return known.mm;
  }
  throw InputError({.what = "unknown unit of length",
                    .where = {.field = "unit"},
                    .got = std::string(unit),
                    .expected = "mm, m, um or in"});
}

const char* name_of(Miss miss) {
  constexpr std::array<const char*, 3> kNames = {"zero", "empty", "deleted"};
  return kNames[static_cast<std::size_t>(miss)];
}

PointsFile parse_points(std::string bytes, const std::string& name, const PointsOptions& options) {
  return PointsReader(points_text(std::move(bytes), name), name, options).read();
}

PointsFile read_points(const std::filesystem::path& path, const PointsOptions& options) {
  return parse_points(read_file(path, kMaxPointsBytes), path.string(), options);
}

void refuse_points(const PointsFile& file, const std::string& what, const std::string& got,
                   const std::string& expected, const std::string& hint) {
  throw InputError(
      {.what = what, .where = {.file = file.name}, .got = got, .expected = expected, .hint = hint});
}

}  // namespace trammel
