#include "core/calibrate/simulation.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/judge/deviation.hpp"

namespace trammel {

std::vector<SimulatedError> simulated_errors(const Correction& correction,
                                             const NominalMachine& machine,
                                             std::span<const Reading> readings) {
  std::vector<const Reading*> rows;
  std::vector<Displacements> cmd_mm;
  std::vector<Pose> targets;  // near which every pose is
  rows.reserve(readings.size());
  cmd_mm.reserve(readings.size());
  targets.reserve(readings.size());
  for (const Reading& r : readings) {
    if (!r.measured) continue;
    rows.push_back(&r);
    cmd_mm.push_back(r.conditions.cmd_mm);
    targets.push_back(r.target);
  }
  std::vector<std::size_t> missed;
  const auto poses_of = [&](const NominalMachine& robot) {
    std::vector<Pose> poses = targets;
    const auto more = robot.poses(cmd_mm, poses);
    missed.insert(missed.end(), more.begin(), more.end());
    return poses;
  };
  const std::vector<Pose> nominal = poses_of(machine);
  std::vector<Pose> simulated;
  if (const auto* identified = std::get_if<GeometryCorrection>(&correction)) {
    Machine built = machine.machine();
    set_geometry(built, identified->geometry);
    simulated = poses_of(built);
  } else if (std::holds_alternative<NominalCorrection>(correction)) {
    simulated = nominal;
  } else {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const ForwardResult at = believed(correction, machine, rows[k]->conditions);
      if (!at.ok()) missed.push_back(k);
      simulated.push_back(at.pose);
    }
  }
  if (!missed.empty()) {
    const Reading& r = *rows[*std::ranges::min_element(missed)];
    throw InputError({.what = "the command of this reading cannot be simulated",
                      .where = {.point = "seq " + std::to_string(r.seq)},
                      .expected = "displacements within the robot's reach"});
  }
  std::vector<SimulatedError> errors;
  errors.reserve(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Pose seen = machine.measured_else(*rows[k]->measured, simulated[k]);
    errors.push_back({.target = rows[k]->target,
                      .measured = pose_difference(seen, nominal[k]),
                      .simulated = pose_difference(simulated[k], nominal[k])});
  }
  return errors;
}

SimulationScore simulation_score(std::span<const SimulatedError> errors) {
  std::vector<double> measured, simulated, left;
  for (const SimulatedError& e : errors) {
    measured.push_back(e.measured.head<2>().norm());
    simulated.push_back(e.simulated.head<2>().norm());
    left.push_back((e.measured - e.simulated).head<2>().norm());
  }
  return {summarise(measured), summarise(simulated), summarise(left)};
}

}  // namespace trammel
