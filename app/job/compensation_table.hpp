#pragma once
// What a controller needs of a model: displacements to command for a grid of targets.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/model/robot_model.hpp"

namespace trammel::job {

struct TableRequest {
  double step_mm = 10;
  double half_width_mm = 100;
  std::vector<double> phi_rad = {0};
  int epoch = 1;
  std::optional<double> temp_degc = {};
  std::optional<double> time_s = {};
};

struct TableRow {
  Pose target;
  std::array<int, kChains> approach = {};  // +1, -1; 0 on a rail whose direction changes nothing
  Displacements cmd_mm = {};               // to command so that the model reads the target
  Displacements correction_mm = {};        // cmd less the nominal displacements
};

struct CompensationTable {
  std::array<bool, kChains> directed = {};  // the commands depend on this rail's approach direction
  int n_targets = 0;                        // of the grid
  int n_unreachable = 0;  // left out: out of reach, beyond a singularity or the stroke
  int n_drives = kChains;
  std::vector<TableRow> rows;  // per target, every combination of the directed rails
};

/// Whether the coordinates that the machine does not move are at home in `target`.
bool moves_to(const Machine& machine, const Pose& target);
/// Whether every drive is within its stroke.
bool within_limits(const Machine& machine, const Displacements& l_mm);

/// Rails on which an effect of the model needs the direction of approach.
std::array<bool, kChains> directed_rails(const RobotModel& robot);

/// One row per target of the square lattice that the machine moves to, orientation, and combination
/// of approach directions that matters. Proof: under the model, each row reads its target to 1e-9
/// mm (stored_model_test.cpp).
/// @throws InputError  a step or width that is not positive, more than a million rows
CompensationTable compensation_table(const RobotModel& robot, const TableRequest& request);

/// As CSV with one header line, '.' as point, lengths to a nanometre.
std::string table_csv(const CompensationTable& table);

}  // namespace trammel::job
