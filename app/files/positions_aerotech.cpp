#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "app/files/points_file.hpp"
#include "app/files/positions_readers.hpp"
#include "core/error.hpp"

namespace trammel {

namespace {

/// "key: value; key: value" of a comment.
void take_pairs(std::string_view comment, std::map<std::string, std::string>& into) {
  while (!comment.empty()) {
    const std::size_t end = std::min(comment.find(';'), comment.size());
    const std::string_view pair = comment.substr(0, end);
    const std::size_t colon = pair.find(':');
    if (colon != std::string_view::npos) {
      const std::string key = single_blanks(pair.substr(0, colon));
      const std::string value = single_blanks(pair.substr(colon + 1));
      if (!key.empty() && !value.empty()) into[key] = value;
    }
    comment.remove_prefix(std::min(end + 1, comment.size()));
  }
}

}  // namespace

PositionsFile aerotech_positions(const PointsText& text, const std::string& name) {
  PositionsFile out{.name = name, .format = "Aerotech calibration"};
  for (const std::string& comment : text.comments) take_pairs(comment, out.facts);
  const auto require = [&](const std::string& key) -> std::string {
    const auto at = out.facts.find(key);
    if (at != out.facts.end()) return at->second;
    throw InputError({.what = "the header of the calibration file lacks a line",
                      .where = {.file = name, .field = key}});
  };
  std::string unit = require("UserUnits");
  std::ranges::transform(unit, unit.begin(), [](unsigned char c) { return std::tolower(c); });
  const double mm = mm_of_unit(unit);
  std::array<Eigen::Index, 2> axis{};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string key = fmt::format("Ax{}Name", k + 1), letter = require(key);
    if (letter != "X" && letter != "Y") {
      throw InputError({.what = "the file is of another axis",
                        .where = {.file = name, .field = key},
                        .got = letter,
                        .expected = "X or Y"});
    }
    axis[k] = letter == "X" ? 0 : 1;
  }
  if (axis[0] == axis[1]) {
    throw InputError({.what = "both axes of the file have one name",
                      .where = {.file = name, .field = "Ax2Name"}});
  }
  out.targeted = out.measured = {true, true, false};
  for (const PointsLine& line : text.lines) {
    const std::vector<double> v = numbers_of(line, name, 6);
    Eigen::Vector3d target = Eigen::Vector3d::Zero(), error = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 2; ++k) {
      target[axis[k]] = v[2 + k] * mm;
      error[axis[k]] = v[4 + k] * mm;
    }
    out.rows.push_back({.line = line.number,
                        .target = Pose::from(target),
                        .measured = Pose::from(target + error)});
  }
  out.facts["deviation"] = "measured less commanded, as its errors were taken";
  return out;
}

}  // namespace trammel
