#include "app/job/compensation_table.hpp"

#include <fmt/format.h>

#include <algorithm>

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

bool within(const Limits& limits, const Displacements& l_mm) {
  return (l_mm.array() >= limits.l_min_mm).all() && (l_mm.array() <= limits.l_max_mm).all();
}

/// All rows of one target, or none when one of them cannot be commanded.
std::vector<TableRow> rows_of(const RobotModel& robot, const Mechanism& mechanism,
                              const Pose& target,
                              const std::vector<std::array<int, kChains>>& directions,
                              const TableRequest& request) {
  if (reach(robot.nominal, target).assembly <= 0) return {};
  const InverseResult nominal = inverse(mechanism.geometry, target);
  std::vector<TableRow> rows;
  for (const auto& approach : directions) {
    const Move move{.target = target,
                    .from_mm = nominal.l_mm,
                    .approach = approach,
                    .epoch = request.epoch,
                    .time_s = request.time_s,
                    .temp_degc = request.temp_degc};
    const InverseResult at = commanded(ModelCorrection{robot}, mechanism, move);
    if (!at.ok() || !within(mechanism.limits, at.l_mm)) return {};
    rows.push_back({target, approach, at.l_mm, at.l_mm - nominal.l_mm});
  }
  return rows;
}

std::string direction_cell(int sign) { return sign > 0 ? "+1" : sign < 0 ? "-1" : "0"; }

}  // namespace

std::array<bool, kChains> directed_rails(const RobotModel& robot) {
  std::array<bool, kChains> directed = {};
  for (const ActiveEffect& active : robot.effects) {
    const Effect& effect = *active.effect;
    if (std::find(effect.needs.begin(), effect.needs.end(), Need::direction) ==
        effect.needs.end()) {
      continue;
    }
    for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
      if (active.values[static_cast<Eigen::Index>(k)] == 0) continue;
      const int rail = effect.parameters[k].rail;
      if (rail < 0) return {true, true, true};
      directed[static_cast<std::size_t>(rail)] = true;
    }
  }
  return directed;
}

CompensationTable compensation_table(const RobotModel& robot, const TableRequest& request) {
  check(request);
  CompensationTable table{.directed = directed_rails(robot), .rows = {}};
  const auto directions = approaches(table.directed);
  const Mechanism mechanism = robot.mechanism();
  for (const double phi_rad : request.phi_rad) {
    for (Pose target : lattice(request.half_width_mm, request.step_mm)) {
      target.phi_rad = phi_rad;
      const std::vector<TableRow> rows = rows_of(robot, mechanism, target, directions, request);
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
  text += ",cmd_l1_mm,cmd_l2_mm,cmd_l3_mm,correction_l1_mm,correction_l2_mm,correction_l3_mm\n";
  for (const TableRow& row : table.rows) {
    text += fmt::format("{:.6f},{:.6f},{:.7f}", row.target.x_mm, row.target.y_mm,
                        deg_from_rad(row.target.phi_rad));
    for (std::size_t i = 0; i < kChains; ++i) {
      if (table.directed[i]) text += "," + direction_cell(row.approach[i]);
    }
    for (const Displacements& d : {row.cmd_mm, row.correction_mm}) {
      text += fmt::format(",{:.6f},{:.6f},{:.6f}", d[0], d[1], d[2]);
    }
    text += "\n";
  }
  return text;
}

}  // namespace trammel::job
