#include "app/files/commands_csv.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "app/files/csv.hpp"
#include "app/files/numbers.hpp"
#include "core/mechanism/machine_solver.hpp"

namespace trammel {

namespace {

constexpr double kMax_mm = 1e5;  // no stage is longer: a unit or a typing error
constexpr int kMaxCount = 1000000000;
constexpr std::array<std::string_view, 10> kPassedOver = {
    "set",  "target_x_mm", "target_y_mm", "target_phi_deg", "x_mm",
    "y_mm", "phi_deg",     "approach_l1", "approach_l2",    "approach_l3"};

class CommandReader {
 public:
  CommandReader(const CsvTable& table, const MachineKind& kind)
      : table_(table), kind_(kind), n_(static_cast<std::size_t>(kind.n_chains)) {
    for (std::size_t k = 0; k < table.header.cells.size(); ++k) add_column(k);
    bool has_from = false;
    for (std::size_t i = 0; i < n_; ++i) {
      need(kCmd[i]);
      has_from = has_from || has(kFrom[i]);
    }
    for (std::size_t i = 0; has_from && i < n_; ++i) need(kFrom[i]);
  }

  std::vector<CommandRow> rows(Displacements from_mm) {
    std::vector<CommandRow> all;
    for (const CsvTable::Row& row : table_.rows) {
      row_ = &row;
      CommandRow command = read(from_mm);
      if (command.seq == 0) command.seq = static_cast<int>(all.size()) + 1;
      from_mm = command.conditions.cmd_mm;
      all.push_back(command);
    }
    return all;
  }

 private:
  static constexpr std::array<const char*, 3> kCmd = {"cmd_l1_mm", "cmd_l2_mm", "cmd_l3_mm"};
  static constexpr std::array<const char*, 3> kFrom = {"from_l1_mm", "from_l2_mm", "from_l3_mm"};
  static constexpr std::array<std::string_view, 10> kRead = {
      "cmd_l1_mm",  "cmd_l2_mm", "cmd_l3_mm", "from_l1_mm", "from_l2_mm",
      "from_l3_mm", "epoch",     "time_s",    "temp_degc",  "seq"};

  void add_column(std::size_t k) {
    const std::string_view name = table_.header.cells[k].text;
    if (std::ranges::find(kRead, name) != kRead.end()) {
      require_drive(name, k);
      at_.emplace(name, k);
    } else if (std::ranges::find(kPassedOver, name) == kPassedOver.end() &&
               !name.starts_with("x_")) {
      throw InputError(
          {.what = "unknown column '" + std::string(name) + "'",
           .where = table_.where(table_.header, k),
           .hint = "a column of your own is passed over when its name begins with x_"});
    }
  }

  void require_drive(std::string_view name, std::size_t k) const {
    for (std::size_t i = n_; i < kCmd.size(); ++i) {
      if (name != kCmd[i] && name != kFrom[i]) continue;
      throw InputError({.what = "a drive that the machine has not",
                        .where = table_.where(table_.header, k),
                        .got = std::string(name),
                        .expected = std::string(kCmd[n_ - 1]) + " at most: an " +
                                    std::string(kind_.name) + " machine has " + std::to_string(n_) +
                                    (n_ == 1 ? " drive" : " drives")});
    }
  }

  [[nodiscard]] bool has(std::string_view name) const { return at_.contains(name); }

  void need(const char* name) const {
    if (has(name)) return;
    throw InputError({.what = "the column is missing",
                      .where = {.file = table_.name, .line = table_.header.line, .field = name}});
  }

  [[nodiscard]] std::optional<double> number(std::string_view name, double bound) const {
    const auto at = at_.find(name);
    if (at == at_.end() || row_->cells[at->second].text.empty()) return std::nullopt;
    const auto value = parse_number(row_->cells[at->second].text);
    if (value && std::abs(*value) <= bound) return value;
    throw InputError({.what = value ? "the number is out of all bounds" : "this is no number",
                      .where = table_.where(*row_, at->second),
                      .got = std::string(row_->cells[at->second].text),
                      .expected = "a decimal number with '.'"});
  }

  [[nodiscard]] double length(std::string_view name) const {
    if (const auto value = number(name, kMax_mm)) return *value;
    throw InputError({.what = "the field is empty",
                      .where = table_.where(*row_, at_.find(name)->second),
                      .expected = "a number"});
  }

  [[nodiscard]] int count(std::string_view name, int absent) const {
    const auto value = number(name, kMaxCount);
    if (!value) return absent;
    if (*value >= 1 && *value == static_cast<int>(*value)) return static_cast<int>(*value);
    throw InputError({.what = "this is no count",
                      .where = table_.where(*row_, at_.find(name)->second),
                      .expected = "1, 2, …"});
  }

  [[nodiscard]] CommandRow read(const Displacements& before_mm) const {
    CommandRow row{.seq = count("seq", 0), .conditions = {}};
    for (std::size_t k = 0; k < n_; ++k) {
      const auto i = static_cast<int>(k);
      row.conditions.cmd_mm[i] = length(kCmd[k]);
      row.conditions.from_mm[i] = number(kFrom[k], kMax_mm).value_or(before_mm[i]);
    }
    row.conditions.epoch = count("epoch", 1);
    row.conditions.time_s = number("time_s", 1e10);
    row.conditions.temp_degc = number("temp_degc", 1000);
    return row;
  }

  const CsvTable& table_;
  const MachineKind& kind_;
  std::size_t n_;
  const CsvTable::Row* row_ = nullptr;
  std::map<std::string, std::size_t, std::less<>> at_;
};

}  // namespace

std::vector<CommandRow> read_commands_csv(const std::filesystem::path& path,
                                          const Machine& machine) {
  const InverseResult home = MachineSolver(machine).drives(machine.home);
  if (!home.ok()) throw InputError({.what = "the home pose is out of reach"});
  const CsvTable table = read_csv(path);
  return CommandReader(table, *machine.kind).rows(home.l_mm);
}

}  // namespace trammel
