#include <fmt/format.h>

#include <cmath>
#include <map>

#include "app/files/numbers.hpp"
#include "app/files/points_file.hpp"
#include "app/files/positions_readers.hpp"
#include "core/error.hpp"

namespace trammel {

namespace {

/// Sections "NAME::", lines "Key: value", and lists of numbers.
class RtlReader {
 public:
  RtlReader(const PointsText& text, std::string name, const PositionsOptions& options)
      : text_(text), options_(options) {
    out_.name = std::move(name);
    out_.format = "Renishaw RTL";
  }

  PositionsFile read() {
    for (const PointsLine& line : text_.lines) take(line);
    if (targets_.empty() || out_.rows.empty()) {
      refuse(0, targets_.empty() ? "the file states no targets" : "the file holds no deviations",
             "");
    }
    set_directions();
    out_.targeted = out_.measured = {true, false, false};
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuse(int line, const std::string& what, const std::string& got,
                           const std::string& expected = "", const std::string& hint = "") const {
    throw InputError({.what = what,
                      .where = {.file = out_.name, .line = line},
                      .got = got,
                      .expected = expected,
                      .hint = hint});
  }

  void take(const PointsLine& line) {
    const std::string text = single_blanks(line.text);
    if (text.ends_with("::")) {
      section_ = text.substr(0, text.size() - 2);
      list_.clear();
      return;
    }
    const std::size_t colon = text.find(':');
    if (colon != std::string::npos) {
      list_ = single_blanks(text.substr(0, colon));
      const std::string value = single_blanks(text.substr(colon + 1));
      if (list_ == "Target-count") count_ = parse_integer(value).value_or(0);
      if (list_.starts_with("Target ")) list_ = "Targets";  // "Target positions (mm)"
      if (section_ == "USER-TEXT" && !value.empty()) out_.facts[list_] = value;
      if (list_ != "Targets" || value.empty()) return;
      return take_targets({line.number, value});
    }
    if (section_ == "TARGET DATA" && list_ == "Targets") return take_targets(line);
    if (section_ == "DEVIATIONS" && list_.starts_with("Run")) take_deviation(line);
  }

  void take_targets(const PointsLine& line) {
    for (const double target : numbers_of(line, out_.name, 0)) targets_.push_back(target);
  }

  void take_deviation(const PointsLine& line) {
    if (options_.unit.empty()) {
      refuse(line.number, "the unit of an RTL file's deviations is not stated", "",
             "--unit um or --unit mm");
    }
    if (count_ > 0 && targets_.size() != static_cast<std::size_t>(count_)) {
      refuse(line.number, "another number of targets than the header counts",
             std::to_string(targets_.size()), std::to_string(count_));
    }
    const std::vector<double> v = numbers_of(line, out_.name, 3);
    const bool known = v[1] >= 1 && v[1] <= static_cast<double>(targets_.size());
    if (!known || !(v[0] >= 1) || v[0] != std::floor(v[0]) || v[1] != std::floor(v[1])) {
      refuse(line.number, "no such run or target", fmt::format("run {}, target {}", v[0], v[1]),
             fmt::format("runs from 1, targets 1 to {}", targets_.size()));
    }
    const double target = targets_[static_cast<std::size_t>(v[1]) - 1];
    out_.rows.push_back({.line = line.number,
                         .target = {target, 0, 0},
                         .measured = {target + v[2] * mm_of_unit(options_.unit), 0, 0},
                         .run = static_cast<int>(v[0])});
  }

  /// A run that lists its targets downwards came down; runs that all list them upwards may still
  /// have come both ways: the file does not say.
  void set_directions() {
    std::map<int, std::vector<PositionRow*>> runs;
    for (PositionRow& row : out_.rows) runs[row.run].push_back(&row);
    bool all_up = true;
    for (auto& [run, rows] : runs) {
      const bool up = rows.back()->target.x_mm >= rows.front()->target.x_mm;
      all_up = all_up && up;
      for (PositionRow* row : rows) row->direction = up ? 1 : -1;
    }
    if (!all_up || runs.size() == 1 || options_.runs == "one-way") return;
    if (options_.runs.empty()) {
      refuse(0, "every run lists its targets upwards: the file does not say which came back", "",
             "--runs one-way, or --runs both-ways (every second one came back)");
    }
    for (auto& [run, rows] : runs) {
      for (PositionRow* row : rows) row->direction = run % 2 == 1 ? 1 : -1;
    }
  }

  const PointsText& text_;
  const PositionsOptions& options_;
  PositionsFile out_;
  std::string section_, list_;
  std::vector<double> targets_;
  int count_ = 0;
};

}  // namespace

PositionsFile rtl_positions(const PointsText& text, const std::string& name,
                            const PositionsOptions& options) {
  return RtlReader(text, name, options).read();
}

}  // namespace trammel
