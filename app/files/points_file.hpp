#pragma once
// Points as trackers' programs write them: several formats, one table of points.

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "app/files/points_format.hpp"
#include "app/files/tracker_clock.hpp"

namespace trammel {

/// Lengths a points file may be in: mm, m, um, in. Throws InputError for others.
double mm_of_unit(std::string_view unit);

/// Why a row is no point: "0 0 0", "empty", "deleted".
enum class Miss { zero, empty, deleted };
const char* name_of(Miss miss);

struct PointsOptions {
  std::string format = {};  // empty: recognised
  std::string unit = {};    // empty: as the file states, mm where it does not
  std::optional<DateOrder> date = {};
  char decimal = '.';
  std::set<Miss> misses = {Miss::zero, Miss::empty, Miss::deleted};
};

struct PointRow {
  int line = 0;            // from 1
  std::string group = {};  // as the file names it, if it does
  std::string name = {};
  std::optional<Miss> miss = {};
  Eigen::Vector3d at_mm = Eigen::Vector3d::Zero();  // no miss
  std::optional<ClockReading> clock = {};
  std::optional<double> temp_degc = {};
  std::optional<double> u95_mm = {};
  std::string raw = {};  // the line as it stood, in UTF-8
};

struct PointsFile {
  std::string name = {};  // the file, as errors show it
  std::string format = {};
  std::string unit = {};
  bool unit_stated = false;     // by the file
  std::string frame = {};       // the coordinate frame, where the file names it
  std::string program = {};     // that wrote it, where the file names it
  bool code_page_1252 = false;  // was not UTF-8
  std::vector<PointRow> rows = {};
  /// Day or month first, where the dates decide or `options.date` does; else why not.
  DateReading dates = {};
};

inline constexpr std::size_t kMaxPointsBytes = 64u << 20;

/// Reads `path`. The delimiter is the first of the format's that the line has. Lines that begin
/// with //, # or % are comments; blank lines are passed over; CRLF, a missing last newline, a byte
/// order mark and trailing empty columns do no harm. Text that is not UTF-8 is taken as code page
/// 1252. A leading apostrophe of a time is dropped.
/// Throws NotFoundError; InputError with line and column: a format that is not recognised, text
/// where a number should be, too few or too many fields, axes that are not cartesian, a unit other
/// than the one asked for. Proof: points_file_test.cpp, and on real files where they are there.
PointsFile read_points(const std::filesystem::path& path, const PointsOptions& options);
PointsFile parse_points(std::string bytes, const std::string& name, const PointsOptions& options);

/// Throws InputError about the file as a whole.
[[noreturn]] void refuse_points(const PointsFile& file, const std::string& what,
                                const std::string& got, const std::string& expected,
                                const std::string& hint = "");

}  // namespace trammel
