#include "app/files/readings_csv.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <unordered_map>

#include "app/files/csv.hpp"
#include "app/files/numbers.hpp"
#include "core/measure/gross.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

enum Column {
  kSeq,
  kSet,
  kEpoch,
  kTargetX,
  kTargetY,
  kTargetPhi,
  kCmd1,
  kCmd2,
  kCmd3,
  kFrom1,
  kFrom2,
  kFrom3,
  kX,
  kY,
  kPhi,
  kTime,
  kTemp,
  kColumns
};

struct ColumnRule {
  const char* name;
  bool needed;
};

constexpr std::array<ColumnRule, kColumns> kRules = {{
    {"seq", true},
    {"set", false},
    {"epoch", false},
    {"target_x_mm", true},
    {"target_y_mm", true},
    {"target_phi_deg", true},
    {"cmd_l1_mm", true},
    {"cmd_l2_mm", true},
    {"cmd_l3_mm", true},
    {"from_l1_mm", false},
    {"from_l2_mm", false},
    {"from_l3_mm", false},
    {"x_mm", true},
    {"y_mm", true},
    {"phi_deg", true},
    {"time_s", false},
    {"temp_degc", false},
}};

constexpr std::array<const char*, 3> kSetNames = {"identify", "validate", "predict"};

/// Bounds that no stage leaves; what is outside is a unit or a typing error, not data.
constexpr double kMaxPose_mm = 1e5;
constexpr double kMaxTime_s = 1e10;
constexpr double kMinTemp_degc = -273.15;
constexpr double kMaxTemp_degc = 1000;

/// Reads the table's rows one after the other.
class Reader {
 public:
  Reader(const CsvTable& table, CampaignFile& file) : table_(table), file_(file) {
    at_.fill(std::nullopt);
    for (std::size_t k = 0; k < table.header.cells.size(); ++k) add_column(k);
    refuse_unknown();
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (kRules[c].needed && !at_[c]) missing_column(kRules[c].name);
    }
    const std::array<Column, 3> from = {kFrom1, kFrom2, kFrom3};
    const auto there = [this](Column c) { return at_[c].has_value(); };
    if (std::any_of(from.begin(), from.end(), there)) {
      for (const Column c : from) {
        if (!there(c)) missing_column(kRules[c].name);
      }
    }
    const InverseResult home =
        inverse(file.campaign.mechanism.geometry, file.campaign.mechanism.home);
    if (!home.ok()) {
      throw InputError({.what = "the home pose is out of reach",
                        .where = {.file = table.name, .field = "mechanism.home"}});
    }
    previous_cmd_mm_ = home.l_mm;
  }

  void read_all() {
    if (table_.rows.empty()) {
      throw InputError({.what = "there are no readings",
                        .where = {.file = table_.name, .line = table_.header.line},
                        .expected = "a line for each reading below the header"});
    }
    std::unordered_map<int, int> line_of_seq;
    for (const CsvTable::Row& row : table_.rows) {
      row_ = &row;
      Reading reading = read_row();
      const auto [first, is_new] = line_of_seq.emplace(reading.seq, row.line);
      if (!is_new) {
        refuse(kSeq, "duplicate seq",
               "numbers that differ (first in line " + std::to_string(first->second) + ")");
      }
      look_for_reach(reading);
      previous_cmd_mm_ = reading.conditions.cmd_mm;
      file_.campaign.readings.push_back(std::move(reading));
      file_.extras.push_back(read_extras());
    }
    sort_by_seq();
    // What the screen explains is no row's own fault: the door names it.
    if (out_of_reach_ && gross_mistakes(file_.campaign).empty()) throw *out_of_reach_;
  }

 private:
  void add_column(std::size_t k) {
    const std::string_view name = table_.header.cells[k].text;
    const auto rule = std::find_if(kRules.begin(), kRules.end(),
                                   [name](const ColumnRule& r) { return name == r.name; });
    if (rule != kRules.end()) {
      at_[static_cast<std::size_t>(rule - kRules.begin())] = k;
    } else if (name.starts_with("x_")) {
      extra_at_.push_back(k);
      file_.extra_columns.emplace_back(name);
    } else {
      unknown_.push_back(k);
    }
  }

  /// All of them, so that one look mends the file.
  void refuse_unknown() const {
    if (unknown_.empty()) return;
    std::string names;
    for (const std::size_t k : unknown_) {
      names += (names.empty() ? "'" : ", '") + std::string(table_.header.cells[k].text) + "'";
    }
    throw InputError(
        {.what = (unknown_.size() == 1 ? "unknown column " : "unknown columns ") + names,
         .where = table_.where(table_.header, unknown_.front()),
         .hint = "a column of your own is kept when its name begins with x_"});
  }

  [[noreturn]] void missing_column(const char* name) const {
    throw InputError({.what = "the column is missing",
                      .where = {.file = table_.name, .line = table_.header.line, .field = name}});
  }

  [[noreturn]] void refuse(Column c, const std::string& what, const std::string& expected,
                           const std::string& hint = "") const {
    const std::size_t k = at_[c].value();
    throw InputError({.what = what,
                      .where = table_.where(*row_, k),
                      .got = "'" + std::string(row_->cells[k].text) + "'",
                      .expected = expected,
                      .hint = hint});
  }

  /// The cell's text; none when the column is absent or the cell is empty.
  [[nodiscard]] std::optional<std::string_view> cell(Column c) const {
    if (!at_[c] || row_->cells[*at_[c]].text.empty()) return std::nullopt;
    return row_->cells[*at_[c]].text;
  }

  [[nodiscard]] std::optional<double> optional_number(Column c, double min, double max) const {
    const auto text = cell(c);
    if (!text) return std::nullopt;
    const auto value = parse_number(*text);
    if (!value) refuse(c, "this is no number", "a decimal number with '.'");
    if (*value < min || *value > max) {
      refuse(c, "the number is out of all bounds", number_text(min) + " to " + number_text(max),
             "is the unit right?");
    }
    return value;
  }

  [[nodiscard]] double number(Column c, double bound) const {
    const auto value = optional_number(c, -bound, bound);
    if (!value) refuse(c, "the field is empty", "a number");
    return *value;
  }

  [[nodiscard]] int count(Column c, std::optional<int> absent, int max) const {
    const auto text = cell(c);
    if (!text && absent) return *absent;
    const auto value = text ? parse_integer(*text) : std::nullopt;
    if (!value || *value < 1 || *value > max) refuse(c, "this is no count", "1, 2, …");
    return *value;
  }

  [[nodiscard]] ReadingSet set() const {
    const auto text = cell(kSet);
    if (!text) return ReadingSet::identify;
    const auto found = std::find(kSetNames.begin(), kSetNames.end(), *text);
    if (found == kSetNames.end()) refuse(kSet, "unknown set", "identify, validate or predict");
    return static_cast<ReadingSet>(found - kSetNames.begin());
  }

  Reading read_row() {
    Reading reading;
    reading.seq = count(kSeq, std::nullopt, 1000000000);
    reading.set = set();
    reading.target = {number(kTargetX, kMaxPose_mm), number(kTargetY, kMaxPose_mm),
                      rad_from_deg(number(kTargetPhi, 3600))};
    reading.conditions = read_conditions();
    reading.measured = read_measured(reading.set, reading.target);
    return reading;
  }

  Conditions read_conditions() {
    Conditions conditions;
    conditions.cmd_mm = {number(kCmd1, kMaxPose_mm), number(kCmd2, kMaxPose_mm),
                         number(kCmd3, kMaxPose_mm)};
    conditions.from_mm = previous_cmd_mm_;
    if (cell(kFrom1) || cell(kFrom2) || cell(kFrom3)) {
      conditions.from_mm = {number(kFrom1, kMaxPose_mm), number(kFrom2, kMaxPose_mm),
                            number(kFrom3, kMaxPose_mm)};
    }
    conditions.epoch = count(kEpoch, 1, 1000000);
    conditions.time_s = optional_number(kTime, -kMaxTime_s, kMaxTime_s);
    conditions.temp_degc = optional_number(kTemp, kMinTemp_degc, kMaxTemp_degc);
    return conditions;
  }

  std::optional<Pose> read_measured(ReadingSet set, const Pose& target) {
    if (set == ReadingSet::predict) {
      for (const Column c : {kX, kY, kPhi}) {
        if (cell(c)) refuse(c, "a predict row with a measured pose", "an empty field");
      }
      return std::nullopt;
    }
    return Pose{number(kX, 10 * kMaxPose_mm), number(kY, 10 * kMaxPose_mm),
                near_target_rad(rad_from_deg(number(kPhi, 36000)), target.phi_rad)};
  }

  void look_for_reach(const Reading& reading) {
    if (out_of_reach_) return;
    try {
      check_reach(reading);
    } catch (const InputError& error) {
      out_of_reach_ = error;
    }
  }

  /// The nominal robot must reach the target, and its rails the command.
  void check_reach(const Reading& reading) const {
    const Mechanism& mechanism = file_.campaign.mechanism;
    const InverseResult at = inverse(mechanism.geometry, reading.target);
    if (!at.ok()) {
      throw InputError(
          {.what = "the target is out of reach of chain " + std::to_string(at.chain + 1),
           .where = [&] {
             Where where = table_.where(*row_, at_[kTargetX].value());
             where.field = "target";
             where.point = "seq " + std::to_string(reading.seq);
             return where;
           }()});
    }
    for (int i = 0; i < kChains; ++i) {
      const Limits& limits = mechanism.limits;
      const double l_mm = reading.conditions.cmd_mm[i];
      if (l_mm < limits.l_min_mm || l_mm > limits.l_max_mm) {
        refuse(static_cast<Column>(kCmd1 + i), "the command is beyond the rail's limits",
               number_text(limits.l_min_mm) + " to " + number_text(limits.l_max_mm) + " mm");
      }
    }
    if (!forward(mechanism.geometry, reading.conditions.cmd_mm, reading.target).ok()) {
      refuse(kCmd1, "no pose belongs to these commands: out of reach",
             "commands the platform can follow");
    }
  }

  [[nodiscard]] std::map<std::string, std::string> read_extras() const {
    std::map<std::string, std::string> extras;
    for (const std::size_t k : extra_at_) {
      const std::string_view text = row_->cells[k].text;
      if (!text.empty()) extras.emplace(table_.header.cells[k].text, undefused(text));
    }
    return extras;
  }

  void sort_by_seq() {
    std::vector<Reading>& readings = file_.campaign.readings;
    std::vector<std::size_t> order(readings.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return readings[a].seq < readings[b].seq; });
    std::vector<Reading> sorted;
    std::vector<std::map<std::string, std::string>> extras;
    for (const std::size_t k : order) {
      sorted.push_back(readings[k]);
      extras.push_back(file_.extras[k]);
    }
    readings = std::move(sorted);
    file_.extras = std::move(extras);
  }

  const CsvTable& table_;
  CampaignFile& file_;
  const CsvTable::Row* row_ = nullptr;
  std::array<std::optional<std::size_t>, kColumns> at_;
  std::vector<std::size_t> unknown_;
  std::vector<std::size_t> extra_at_;
  Displacements previous_cmd_mm_;
  std::optional<InputError> out_of_reach_;  // the first
};

std::string optional_text(const std::optional<double>& value) {
  return value ? number_text(*value) : "";
}

void add_numbers(std::vector<std::string>& cells, const Eigen::Vector3d& values) {
  for (const double value : values) cells.push_back(number_text(value));
}

std::vector<std::string> reading_cells(const Reading& reading) {
  const Conditions& at = reading.conditions;
  std::vector<std::string> cells = {std::to_string(reading.seq), set_name(reading.set),
                                    std::to_string(at.epoch)};
  const auto add_pose = [&cells](const Pose& pose) {
    cells.push_back(number_text(pose.x_mm));
    cells.push_back(number_text(pose.y_mm));
    cells.push_back(number_text(exact_deg(pose.phi_rad)));
  };
  add_pose(reading.target);
  add_numbers(cells, at.cmd_mm);
  add_numbers(cells, at.from_mm);
  if (reading.measured) {
    add_pose(*reading.measured);
  } else {
    cells.insert(cells.end(), 3, "");
  }
  cells.push_back(optional_text(at.time_s));
  cells.push_back(optional_text(at.temp_degc));
  return cells;
}

void add_line(std::string& text, const std::vector<std::string>& cells) {
  for (std::size_t k = 0; k < cells.size(); ++k) text += (k > 0 ? "," : "") + csv_cell(cells[k]);
  text += '\n';
}

}  // namespace

const char* set_name(ReadingSet set) { return kSetNames[static_cast<std::size_t>(set)]; }

void read_readings_csv(const std::filesystem::path& path, CampaignFile& file) {
  const CsvTable table = read_csv(path);
  Reader(table, file).read_all();
}

std::string readings_csv(const CampaignFile& file) {
  std::vector<std::string> header;
  for (const ColumnRule& rule : kRules) header.emplace_back(rule.name);
  header.insert(header.end(), file.extra_columns.begin(), file.extra_columns.end());
  std::string text;
  add_line(text, header);
  for (std::size_t k = 0; k < file.campaign.readings.size(); ++k) {
    std::vector<std::string> cells = reading_cells(file.campaign.readings[k]);
    for (const std::string& column : file.extra_columns) {
      const auto extra = file.extras.at(k).find(column);
      cells.push_back(extra == file.extras.at(k).end() ? "" : defused(extra->second));
    }
    add_line(text, cells);
  }
  return text;
}

}  // namespace trammel
