#include "app/files/readings_csv.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>

#include "app/files/csv.hpp"
#include "app/files/numbers.hpp"
#include "core/measure/gross.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

enum Column : std::size_t {
  kSeq,
  kSession,
  kCompensation,
  kRole,
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

constexpr std::array<const char*, kColumns> kNames = {
    "seq",       "session",     "compensation", "role",           "set",
    "epoch",     "target_x_mm", "target_y_mm",  "target_phi_deg", "cmd_l1_mm",
    "cmd_l2_mm", "cmd_l3_mm",   "from_l1_mm",   "from_l2_mm",     "from_l3_mm",
    "x_mm",      "y_mm",        "phi_deg",      "time_s",         "temp_degc"};

/// Which columns a campaign of this format and machine has.
enum class Need { no, optional, yes };
using Needs = std::array<Need, kColumns>;

Needs needs_of(const CampaignFile& file) {
  Needs needs;
  needs.fill(Need::optional);
  const Need walk = file.format == 1 ? Need::no : Need::optional;
  needs[kSession] = needs[kCompensation] = needs[kRole] = walk;
  needs[kSeq] = Need::yes;
  const Machine& machine = file.campaign.machine;
  for (std::size_t i = 0; i < 3; ++i) {
    const bool has = static_cast<int>(i) < machine.kind->n_chains;
    needs[kTargetX + i] = needs[kCmd1 + i] = has ? Need::yes : Need::no;
    needs[kFrom1 + i] = has ? Need::optional : Need::no;
    needs[kX + i] = machine.measured[i] ? Need::yes : Need::no;
  }
  return needs;
}

constexpr std::array<const char*, 3> kSetNames = {"identify", "validate", "predict"};

/// Bounds that no stage leaves; what is outside is a unit or a typing error, not data.
constexpr double kMaxPose_mm = 1e5;
constexpr double kMaxTime_s = 1e10;
constexpr double kMinTemp_degc = -273.15;
constexpr double kMaxTemp_degc = 1000;

/// Reads the table's rows one after the other.
class Reader {
 public:
  Reader(const CsvTable& table, CampaignFile& file)
      : table_(table),
        file_(file),
        machine_(file.campaign.machine),
        solver_(machine_),
        needs_(needs_of(file)) {
    at_.fill(std::nullopt);
    for (std::size_t k = 0; k < table.header.cells.size(); ++k) add_column(k);
    refuse_unknown();
    const bool has_from = at_[kFrom1] || at_[kFrom2] || at_[kFrom3];
    for (std::size_t c = 0; c < kColumns; ++c) {
      const bool is_from = c >= kFrom1 && c <= kFrom3 && needs_[c] != Need::no;
      const bool needed = needs_[c] == Need::yes || (is_from && has_from);
      if (needed && !at_[c]) missing_column(kNames[c]);
    }
    for (std::size_t k = 0; k < file.sessions.size(); ++k) known_[file.sessions[k].name] = k;
    const InverseResult home = solver_.drives(machine_.home);
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
      if (file_.format > 1) {
        file_.session_of.push_back(session());
        file_.roles.emplace_back(cell(kRole).value_or(""));
      }
      file_.campaign.readings.push_back(std::move(reading));
      file_.extras.push_back(read_extras());
    }
    sort_by_seq();
    require_walks();
    // What the screen explains is no row's own fault: the door names it.
    if (out_of_reach_ && gross_mistakes(file_.campaign).empty()) throw *out_of_reach_;
  }

 private:
  void add_column(std::size_t k) {
    const std::string_view name = table_.header.cells[k].text;
    const auto c = static_cast<std::size_t>(std::ranges::find(kNames, name) - kNames.begin());
    if (c < kColumns && needs_[c] != Need::no) {
      at_[c] = k;
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
         .expected = columns(),
         .hint = "a column of your own is kept when its name begins with x_"});
  }

  /// Those that a campaign of this format and machine may have.
  [[nodiscard]] std::string columns() const {
    std::string names;
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (needs_[c] != Need::no) names += (names.empty() ? "" : ", ") + std::string(kNames[c]);
    }
    return names;
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

  /// The row's walk; one correction a walk.
  std::size_t session() {
    const std::string name(undefused(cell(kSession).value_or("import")));
    if (name.size() > 200) refuse(kSession, "a name that can't be used", "1 to 200 letters");
    const auto [at, is_new] = known_.emplace(name, file_.sessions.size());
    if (is_new) file_.sessions.push_back({.name = name});
    FileSession& session = file_.sessions[at->second];
    const std::string compensation(undefused(cell(kCompensation).value_or("")));
    if (compensation.size() > 200) {
      refuse(kCompensation, "a name that can't be used", "at most 200 letters");
    }
    if (walked_.insert(at->second).second) session.compensation = compensation;
    if (session.compensation != compensation) {
      refuse(kCompensation, "another correction in the same session",
             session.compensation.empty() ? "none, as in the rows before"
                                          : "'" + session.compensation + "', as in the rows before",
             "a walk has one: give the rows another session");
    }
    return at->second;
  }

  /// A walk without a reading is none; an exclusion needs its reading.
  void require_walks() const {
    if (file_.format == 1) return;
    for (std::size_t k = 0; k < file_.sessions.size(); ++k) {
      if (walked_.contains(k)) continue;
      throw InputError({.what = "a session without a reading",
                        .where = {.file = table_.name, .field = "session"},
                        .got = file_.sessions[k].name,
                        .hint = "campaign.json names it in \"sessions\""});
    }
    for (const auto& [seq, reason] : file_.exclusions) {
      if (std::ranges::find(file_.campaign.readings, seq, &Reading::seq) !=
          file_.campaign.readings.end()) {
        continue;
      }
      throw InputError({.what = "an exclusion names a reading that is not there",
                        .where = {.file = table_.name, .point = "seq " + std::to_string(seq)}});
    }
  }

  /// Three cells, those that the campaign has; the others are 0.
  [[nodiscard]] Eigen::Vector3d numbers(Column first, const std::array<double, 3>& bounds) const {
    Eigen::Vector3d values = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const auto c = static_cast<Column>(first + i);
      if (needs_[c] != Need::no) values[static_cast<int>(i)] = number(c, bounds[i]);
    }
    return values;
  }

  Reading read_row() {
    Reading reading;
    reading.seq = count(kSeq, std::nullopt, 1000000000);
    reading.set = set();
    const Eigen::Vector3d target = numbers(kTargetX, {kMaxPose_mm, kMaxPose_mm, 3600});
    reading.target = {target[0], target[1], rad_from_deg(target[2])};
    reading.conditions = read_conditions();
    reading.measured = read_measured(reading.set, reading.target);
    return reading;
  }

  Conditions read_conditions() {
    constexpr std::array<double, 3> kBounds = {kMaxPose_mm, kMaxPose_mm, kMaxPose_mm};
    Conditions conditions;
    conditions.cmd_mm = numbers(kCmd1, kBounds);
    conditions.from_mm = previous_cmd_mm_;
    if (cell(kFrom1) || cell(kFrom2) || cell(kFrom3)) conditions.from_mm = numbers(kFrom1, kBounds);
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
    const Eigen::Vector3d at = numbers(kX, {10 * kMaxPose_mm, 10 * kMaxPose_mm, 36000});
    const bool has_phi = needs_[kPhi] != Need::no;
    return Pose{at[0], at[1], has_phi ? near_target_rad(rad_from_deg(at[2]), target.phi_rad) : 0};
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
    const InverseResult at = solver_.drives(reading.target);
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
    for (int i = 0; i < machine_.kind->n_chains; ++i) {
      const Limits& limits = machine_.drives[static_cast<std::size_t>(i)].limits;
      const double l_mm = reading.conditions.cmd_mm[i];
      if (l_mm < limits.l_min_mm || l_mm > limits.l_max_mm) {
        refuse(static_cast<Column>(kCmd1 + static_cast<std::size_t>(i)),
               "the command is beyond the drive's limits",
               number_text(limits.l_min_mm) + " to " + number_text(limits.l_max_mm) + " mm");
      }
    }
    if (!solver_.pose(reading.conditions.cmd_mm, reading.target).ok()) {
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
    const auto sort = [&order](auto& list) {
      if (list.empty()) return;
      auto sorted = list;
      for (std::size_t k = 0; k < order.size(); ++k) sorted[k] = std::move(list[order[k]]);
      list = std::move(sorted);
    };
    sort(readings);
    sort(file_.extras);
    sort(file_.session_of);
    sort(file_.roles);
    if (std::ranges::all_of(file_.roles, &std::string::empty)) file_.roles.clear();
  }

  const CsvTable& table_;
  CampaignFile& file_;
  const Machine& machine_;
  MachineSolver solver_;
  Needs needs_;
  std::map<std::string, std::size_t> known_;  // sessions by name
  std::set<std::size_t> walked_;              // those that have a reading
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

/// Every column's cell, of which a campaign has some.
std::array<std::string, kColumns> reading_cells(const CampaignFile& file, std::size_t k) {
  const Reading& reading = file.campaign.readings[k];
  const Conditions& at = reading.conditions;
  const FileSession& session = file.sessions[file.session_of.empty() ? 0 : file.session_of[k]];
  std::array<std::string, kColumns> cells;
  cells[kSeq] = std::to_string(reading.seq);
  cells[kSession] = defused(session.name);
  cells[kCompensation] = defused(session.compensation);
  if (!file.roles.empty()) cells[kRole] = file.roles[k];
  cells[kSet] = set_name(reading.set);
  cells[kEpoch] = std::to_string(at.epoch);
  const auto add = [&cells](Column first, const Eigen::Vector3d& values, bool pose) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double value = values[static_cast<int>(i)];
      cells[first + i] = number_text(pose && i == 2 ? exact_deg(value) : value);
    }
  };
  add(kTargetX, reading.target.vector(), true);
  add(kCmd1, at.cmd_mm, false);
  add(kFrom1, at.from_mm, false);
  if (reading.measured) add(kX, reading.measured->vector(), true);
  cells[kTime] = optional_text(at.time_s);
  cells[kTemp] = optional_text(at.temp_degc);
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
  Needs needs = needs_of(file);
  if (file.roles.empty()) needs[kRole] = Need::no;
  const auto chosen = [&needs](const auto& cells) {
    std::vector<std::string> some;
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (needs[c] != Need::no) some.emplace_back(cells[c]);
    }
    return some;
  };
  std::vector<std::string> header = chosen(kNames);
  header.insert(header.end(), file.extra_columns.begin(), file.extra_columns.end());
  std::string text;
  add_line(text, header);
  for (std::size_t k = 0; k < file.campaign.readings.size(); ++k) {
    std::vector<std::string> cells = chosen(reading_cells(file, k));
    for (const std::string& column : file.extra_columns) {
      const auto extra = file.extras.at(k).find(column);
      cells.push_back(extra == file.extras.at(k).end() ? "" : defused(extra->second));
    }
    add_line(text, cells);
  }
  return text;
}

}  // namespace trammel
