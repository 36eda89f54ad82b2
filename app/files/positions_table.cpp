#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <set>

#include "app/files/numbers.hpp"
#include "app/files/points_file.hpp"
#include "app/files/positions_readers.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

enum class Role { none, target, measured, deviation, run, direction, axis, time, temperature };

/// What a word of a column's name says of its role; "dx" says a coordinate too. A weak one says it
/// where no other word does: a target position is a target.
struct RoleWord {
  std::string_view word;
  Role role;
  bool weak = false;
};
constexpr std::array<RoleWord, 34> kRoleWords = {{
    {"command", Role::target},
    {"setpoint", Role::target},
    {"demand", Role::target},
    {"desired", Role::target},
    {"reference", Role::target},
    {"observed", Role::measured},
    {"measurement", Role::measured},
    {"real", Role::measured},
    {"pos", Role::measured, true},
    {"nominal", Role::target},
    {"target", Role::target},
    {"commanded", Role::target},
    {"cmd", Role::target},
    {"measured", Role::measured},
    {"meas", Role::measured},
    {"actual", Role::measured},
    {"position", Role::measured, true},
    {"reading", Role::measured, true},
    {"laser", Role::measured},
    {"external", Role::measured},
    {"interferometer", Role::measured},
    {"error", Role::deviation},
    {"err", Role::deviation},
    {"deviation", Role::deviation},
    {"dev", Role::deviation},
    {"dx", Role::deviation},
    {"dy", Role::deviation},
    {"dphi", Role::deviation},
    {"run", Role::run},
    {"direction", Role::direction},
    {"dir", Role::direction},
    {"axis", Role::axis, true},
    {"time", Role::time},
    {"temp", Role::temperature},
}};

struct AngleUnit {
  std::string_view name;
  double rad;
};
constexpr std::array<AngleUnit, 5> kAngleUnits = {{{"deg", rad_from_deg(1)},
                                                   {"rad", 1},
                                                   {"mrad", 1e-3},
                                                   {"urad", 1e-6},
                                                   {"arcsec", rad_from_deg(1) / 3600}}};
constexpr std::array<std::string_view, 4> kLengthUnits = {"mm", "um", "m", "in"};

/// Lower-case words; the sign of micro is a u.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (std::size_t k = 0; k < name.size(); ++k) {
    const auto c = static_cast<unsigned char>(name[k]);
    const bool micro = (c == 0xC2 || c == 0xCE) && k + 1 < name.size() &&
                       (static_cast<unsigned char>(name[k + 1]) == 0xB5 ||
                        static_cast<unsigned char>(name[k + 1]) == 0xBC);
    if (micro) {
      words.back() += 'u';
      ++k;
    } else if (std::isalnum(c) != 0) {
      words.back() += static_cast<char>(std::tolower(c));
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

struct PositionColumn {
  Role role = Role::none;
  int coordinate = -1;   // 0, 1, 2
  std::string unit;      // as written; empty: none
  bool strange = false;  // holds a word that says nothing here
};

PositionColumn column_of(std::string_view name) {
  PositionColumn column;
  for (const std::string& word : words_of(name)) {
    const auto* coordinate = std::ranges::find(kCoordinateNames, word);
    const auto* role = std::ranges::find(kRoleWords, word, &RoleWord::word);
    const bool is_unit =
        std::ranges::find(kLengthUnits, word) != kLengthUnits.end() ||
        std::ranges::find(kAngleUnits, word, &AngleUnit::name) != kAngleUnits.end() ||
        word == "s" || word == "degc";
    if (coordinate != kCoordinateNames.end()) {
      column.coordinate = static_cast<int>(coordinate - kCoordinateNames.begin());
    } else if (role != kRoleWords.end()) {
      if (column.role == Role::none || !role->weak) column.role = role->role;
      if (word.size() > 1 && word[0] == 'd' && role->role == Role::deviation && word != "dev" &&
          word != "deviation") {
        column.coordinate = static_cast<int>(std::ranges::find(kCoordinateNames, word.substr(1)) -
                                             kCoordinateNames.begin());
      }
    } else if (is_unit) {
      column.unit = word;
    } else {
      column.strange = true;
    }
  }
  return column;
}

/// A table with a header line.
class TableReader {
 public:
  TableReader(const CsvTable& table, const PositionsOptions& options)
      : table_(table), options_(options) {
    for (const CsvCell& cell : table.header.cells) columns_.push_back(column_of(cell.text));
    settle_bare_coordinates();
  }

  PositionsFile read() {
    out_.name = table_.name;
    out_.format = "table";
    look_at_columns();
    for (const CsvTable::Row& row : table_.rows) read_row(row);
    if (out_.rows.empty() && !axes_.empty()) {
      refuse_all("the table does not hold this axis", options_.axis,
                 fmt::format("{}", fmt::join(axes_, ", ")));
    }
    if (out_.rows.empty()) refuse_all("there are no positions", "", "rows below the header");
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuse_all(const std::string& what, const std::string& got,
                               const std::string& expected, const std::string& hint = "") const {
    throw InputError({.what = what,
                      .where = {.file = table_.name, .line = table_.header.line},
                      .got = got,
                      .expected = expected,
                      .hint = hint});
  }
  [[noreturn]] void refuse(const CsvTable::Row& row, std::size_t k, const std::string& what,
                           const std::string& expected) const {
    throw InputError({.what = what,
                      .where = table_.where(row, k),
                      .got = std::string(row.cells[k].text),
                      .expected = expected});
  }

  [[nodiscard]] bool has(Role role) const {
    return std::ranges::any_of(columns_, [&](const PositionColumn& c) { return c.role == role; });
  }

  /// x beside a target is measured, beside a deviation or what was measured the target; of one
  /// axis, what has no coordinate's name is x.
  void settle_bare_coordinates() {
    const bool target = has(Role::target);
    const bool other = has(Role::deviation) || has(Role::measured);
    const auto holds = [this](Role role, int coordinate) {
      return std::ranges::any_of(columns_, [role, coordinate](const PositionColumn& c) {
        return c.role == role && c.coordinate == coordinate;
      });
    };
    for (PositionColumn& c : columns_) {
      const bool bare = c.role == Role::none && c.coordinate >= 0 && !c.strange;
      if (!bare || !(target || other)) continue;
      const bool is_target =
          (holds(Role::deviation, c.coordinate) || holds(Role::measured, c.coordinate)) &&
          !holds(Role::target, c.coordinate);
      c.role = target && !is_target ? Role::measured : Role::target;
    }
    for (PositionColumn& c : columns_) {
      const bool position =
          c.role == Role::target || c.role == Role::measured || c.role == Role::deviation;
      if (options_.one_axis && position && c.coordinate < 0) c.coordinate = 0;
    }
  }

  /// Of one coordinate in one role; columns_.size(): none. Two are refused.
  [[nodiscard]] std::size_t place(Role role, int coordinate) const {
    std::size_t found = columns_.size();
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      if (columns_[k].role != role || columns_[k].coordinate != coordinate) continue;
      if (found < columns_.size()) {
        refuse_all("two columns say the same",
                   std::string(table_.header.cells[found].text) + " and " +
                       std::string(table_.header.cells[k].text),
                   "one of them: rename or remove the other");
      }
      found = k;
    }
    return found;
  }

  void look_at_columns() {
    constexpr std::array<Role, 3> kRoles = {Role::target, Role::measured, Role::deviation};
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      for (std::size_t r = 0; r < kRoles.size(); ++r) at_[r][i] = place(kRoles[r], c);
      out_.targeted[i] = at_[0][i] < columns_.size();
      out_.measured[i] = at_[1][i] < columns_.size() || at_[2][i] < columns_.size();
      if (at_[1][i] < columns_.size() && at_[2][i] < columns_.size()) {
        refuse_all("a measured position and a deviation of the same coordinate",
                   std::string(kCoordinateNames[i]), "one of them");
      }
    }
    for (const Role role : {Role::run, Role::direction, Role::axis, Role::time, Role::temperature})
      other_[static_cast<std::size_t>(role)] = place(role, -1);
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const Role role = columns_[k].role;
      const bool position =
          role == Role::target || role == Role::measured || role == Role::deviation;
      if (role != Role::none && (!position || columns_[k].coordinate >= 0)) continue;
      out_.unused.emplace_back(table_.header.cells[k].text);
      columns_[k].role = Role::none;
    }
    if (!out_.targeted[0] || !out_.measured[0]) {
      std::vector<std::string_view> names;
      for (const CsvCell& cell : table_.header.cells) names.push_back(cell.text);
      if (std::ranges::all_of(names, [](std::string_view n) {
            return n.find_first_not_of("0123456789.,+-eE") == std::string_view::npos;
          })) {
        refuse_all("the line that names the columns is missing",
                   fmt::format("{}", fmt::join(names, ", ")),
                   options_.one_axis ? "target_mm,direction,run,position_mm or the like"
                                     : "target_x_mm,target_y_mm,x_mm,y_mm or the like");
      }
      refuse_all(out_.targeted[0] ? "no column holds what was measured"
                                  : "no column holds what was commanded",
                 fmt::format("{}", fmt::join(names, ", ")),
                 options_.one_axis ? "target_mm, direction, run, position_mm or deviation_um"
                                   : "target_x_mm, target_y_mm, and x_mm, y_mm or dx_um, dy_um");
    }
    for (std::size_t i = 0; i < 2; ++i) {
      if (out_.targeted[i] == out_.measured[i]) continue;
      refuse_all(
          std::string(kCoordinateNames[i]) + (out_.targeted[i] ? " is commanded and not measured"
                                                               : " is measured and not commanded"),
          "", "both, or neither");
    }
  }

  /// One unit in mm or rad.
  [[nodiscard]] double unit_of(std::size_t k) const {
    const PositionColumn& c = columns_[k];
    const auto header = std::string(table_.header.cells[k].text);
    if (c.coordinate == 2) {
      const auto* unit = std::ranges::find(kAngleUnits, c.unit, &AngleUnit::name);
      if (unit != kAngleUnits.end()) return unit->rad;
      refuse_all("an angle without a unit of angles", header, header + "_deg, _rad or _urad");
    }
    const std::string& unit = c.unit.empty() ? options_.unit : c.unit;
    if (std::ranges::find(kLengthUnits, unit) == kLengthUnits.end()) {
      refuse_all(
          unit.empty() ? "the unit of the positions is not stated" : "this is no unit of lengths",
          header, "mm, um, m or in", "name it in the column, as x_mm, or by --unit");
    }
    return mm_of_unit(unit);
  }

  [[nodiscard]] double number(const CsvTable::Row& row, std::size_t k) const {
    const auto value = parse_number(row.cells[k].text);
    if (!value) refuse(row, k, "this is no number", "a decimal number");
    return *value;
  }

  [[nodiscard]] int direction(const CsvTable::Row& row, std::size_t k) const {
    constexpr std::array<std::pair<std::string_view, int>, 12> kWords = {{{"1", 1},
                                                                          {"+1", 1},
                                                                          {"+", 1},
                                                                          {"up", 1},
                                                                          {"forward", 1},
                                                                          {"positive", 1},
                                                                          {"-1", -1},
                                                                          {"-", -1},
                                                                          {"down", -1},
                                                                          {"reverse", -1},
                                                                          {"backward", -1},
                                                                          {"negative", -1}}};
    const auto* at =
        std::ranges::find(kWords, row.cells[k].text, &std::pair<std::string_view, int>::first);
    if (at == kWords.end()) refuse(row, k, "this is no direction", "1 or -1, up or down");
    return at->second;
  }

  [[nodiscard]] bool is_asked_for(const CsvTable::Row& row) {
    const std::size_t k = other_[static_cast<std::size_t>(Role::axis)];
    if (k >= columns_.size()) return true;
    const std::string axis(row.cells[k].text);
    const bool is_new = axes_.insert(axis).second;
    if (!options_.axis.empty()) return axis == options_.axis;
    if (is_new && axes_.size() > 1) {
      refuse_all("the table holds several axes", fmt::format("{}", fmt::join(axes_, ", ")),
                 "one of them", "--only AXIS");
    }
    out_.facts["axis"] = axis;
    return true;
  }

  /// A node that was not measured: nothing stands where positions would.
  [[nodiscard]] bool is_missed(const CsvTable::Row& row) const {
    for (std::size_t role = 1; role < at_.size(); ++role) {
      for (const std::size_t k : at_[role]) {
        if (k < columns_.size() && !row.cells[k].text.empty()) return false;
      }
    }
    return true;
  }

  void read_row(const CsvTable::Row& row) {
    if (!is_asked_for(row)) return;
    if (is_missed(row)) {
      ++out_.missed;
      return;
    }
    PositionRow position;
    position.line = row.line;
    Eigen::Vector3d target = Eigen::Vector3d::Zero(), measured = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const auto c = static_cast<Eigen::Index>(i);
      const auto value = [&](std::size_t role) {
        return number(row, at_[role][i]) * unit_of(at_[role][i]);
      };
      if (at_[0][i] < columns_.size()) target[c] = value(0);
      if (at_[1][i] < columns_.size()) measured[c] = value(1);
      if (at_[2][i] < columns_.size()) measured[c] = target[c] + value(2);
    }
    position.target = Pose::from(target);
    position.measured = Pose::from(measured);
    const auto other = [&](Role role) { return other_[static_cast<std::size_t>(role)]; };
    const auto given = [&](Role role) { return other(role) < columns_.size(); };
    if (given(Role::direction)) position.direction = direction(row, other(Role::direction));
    if (given(Role::run)) {
      const auto run = parse_integer(row.cells[other(Role::run)].text);
      if (!run || *run < 1) refuse(row, other(Role::run), "this is no number of a run", "1, 2, …");
      position.run = *run;
    }
    if (given(Role::time)) position.time_s = number(row, other(Role::time));
    if (given(Role::temperature)) position.temp_degc = number(row, other(Role::temperature));
    out_.rows.push_back(position);
  }

  const CsvTable& table_;
  const PositionsOptions& options_;
  std::vector<PositionColumn> columns_;
  std::array<std::array<std::size_t, 3>, 3> at_{};  // by role and coordinate
  std::array<std::size_t, 9> other_{};              // by Role
  std::set<std::string> axes_;
  PositionsFile out_;
};

}  // namespace

PositionsFile table_positions(const CsvTable& table, const PositionsOptions& options) {
  return TableReader(table, options).read();
}

}  // namespace trammel
