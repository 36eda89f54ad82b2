#include "app/job/compensation_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/calibrate/correction.hpp"
#include "core/error.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "core/plan/grids.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr double kMaxRows = 1e6;

/// Every combination of +1 and -1 on the directed rails, 0 on the others.
std::vector<std::array<int, kChains>> approaches(const std::array<bool, kChains>& directed) {
  std::vector<std::array<int, kChains>> all = {{}};
  for (std::size_t i = 0; i < kChains; ++i) {
    if (!directed[i]) continue;
    std::vector<std::array<int, kChains>> both;
    for (std::array<int, kChains> a : all) {
      for (const int sign : {1, -1}) {
        a[i] = sign;
        both.push_back(a);
      }
    }
    all = std::move(both);
  }
  return all;
}

void check(const TableRequest& r) {
  const auto refuse = [](const char* field, const char* expected) {
    throw InputError(
        {.what = "this grid makes no table", .where = {.field = field}, .expected = expected});
  };
  if (!(r.step_mm > 0)) refuse("--step-mm", "more than 0");
  if (!(r.half_width_mm >= 0 && r.half_width_mm < 1e5)) refuse("--half-width-mm", "0 to 100000");
  const double across = 2 * r.half_width_mm / r.step_mm + 1;
  if (across * across * static_cast<double>(r.phi_rad.size()) * 8 > kMaxRows) {
    refuse("--step-mm", "a table of at most a million rows");
  }
}

/// All rows of one target, or none when one of them cannot be commanded.
std::vector<TableRow> rows_of(const RobotModel& robot, const NominalMachine& machine,
                              const Pose& target,
                              const std::vector<std::array<int, kChains>>& directions,
                              const TableRequest& request) {
  if (reach(robot.nominal, target).assembly <= 0) return {};
  const InverseResult nominal = machine.drives(target);
  std::vector<TableRow> rows;
  for (const auto& approach : directions) {
    const Move move{.target = target,
                    .from_mm = nominal.l_mm,
                    .approach = approach,
                    .epoch = request.epoch,
                    .time_s = request.time_s,
                    .temp_degc = request.temp_degc};
    const InverseResult at = commanded(ModelCorrection{robot}, machine, move);
    if (!at.ok() || !within_limits(robot.nominal, at.l_mm)) return {};
    rows.push_back({target, approach, at.l_mm, at.l_mm - nominal.l_mm});
  }
  return rows;
}

std::string direction_cell(int sign) { return sign > 0 ? "+1" : sign < 0 ? "-1" : "0"; }

}  // namespace

bool moves_to(const Machine& machine, const Pose& target) {
  const Eigen::Vector3d away = target.vector() - machine.home.vector();
  for (int c = machine.kind->n_chains; c < 3; ++c) {
    if (std::abs(away[c]) > kStandstillMm) return false;
  }
  return true;
}

bool within_limits(const Machine& machine, const Displacements& l_mm) {
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    const Limits& limits = machine.drives[static_cast<std::size_t>(i)].limits;
    if (!(l_mm[i] >= limits.l_min_mm && l_mm[i] <= limits.l_max_mm)) return false;
  }
  return true;
}

std::array<bool, kChains> directed_rails(const RobotModel& robot) {
  std::array<bool, kChains> directed = {};
  for (const ActiveEffect& active : robot.effects) {
    const Effect& effect = *active.effect;
    if (std::find(effect.needs.begin(), effect.needs.end(), Need::direction) ==
        effect.needs.end()) {
      continue;
    }
    for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
      if (active.values[static_cast<Eigen::Index>(k)] == 0 || is_shape(effect, static_cast<int>(k)))
        continue;
      const int rail = effect.parameters[k].rail;
      if (rail < 0) {
        const int n = robot.nominal.kind->n_chains;
        return {true, n > 1, n > 2};
      }
      directed[static_cast<std::size_t>(rail)] = true;
    }
  }
  return directed;
}

CompensationTable compensation_table(const RobotModel& robot, const TableRequest& request) {
  check(request);
  CompensationTable table{.directed = directed_rails(robot), .rows = {}};
  const auto directions = approaches(table.directed);
  table.n_drives = robot.nominal.kind->n_chains;
  const NominalMachine machine(robot.nominal);
  for (const double phi_rad : request.phi_rad) {
    for (Pose target : lattice(request.half_width_mm, request.step_mm)) {
      target.phi_rad = phi_rad;
      if (!moves_to(robot.nominal, target)) continue;
      const std::vector<TableRow> rows = rows_of(robot, machine, target, directions, request);
      ++table.n_targets;
      table.n_unreachable += rows.empty() ? 1 : 0;
      table.rows.insert(table.rows.end(), rows.begin(), rows.end());
    }
  }
  return table;
}

std::string table_csv(const CompensationTable& table) {
  std::string text = "target_x_mm,target_y_mm,target_phi_deg";
  for (std::size_t i = 0; i < kChains; ++i) {
    if (table.directed[i]) text += fmt::format(",approach_l{}", i + 1);
  }
  for (const char* column : {"cmd", "correction"}) {
    for (int i = 1; i <= table.n_drives; ++i) text += fmt::format(",{}_l{}_mm", column, i);
  }
  text += "\n";
  for (const TableRow& row : table.rows) {
    text += fmt::format("{:.6f},{:.6f},{:.7f}", row.target.x_mm, row.target.y_mm,
                        deg_from_rad(row.target.phi_rad));
    for (std::size_t i = 0; i < kChains; ++i) {
      if (table.directed[i]) text += "," + direction_cell(row.approach[i]);
    }
    for (const Displacements& d : {row.cmd_mm, row.correction_mm}) {
      for (int i = 0; i < table.n_drives; ++i) text += fmt::format(",{:.6f}", d[i]);
    }
    text += "\n";
  }
  return text;
}

}  // namespace trammel::job
