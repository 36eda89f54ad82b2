#include "core/calibrate/simulation.hpp"

#include "core/assess/deviation.hpp"
#include "core/error.hpp"

namespace trammel {

std::vector<SimulatedError> simulated_errors(const Correction& correction,
                                             const Mechanism& mechanism,
                                             std::span<const Reading> readings) {
  std::vector<SimulatedError> errors;
  const RailFrames nominal_rails = rail_frames(mechanism.geometry);
  const auto* identified = std::get_if<GeometryCorrection>(&correction);
  const RailFrames rails = identified ? rail_frames(identified->geometry) : nominal_rails;
  const bool is_geometry = identified || std::holds_alternative<NominalCorrection>(correction);
  for (const Reading& r : readings) {
    if (!r.measured) continue;
    const Displacements& cmd_mm = r.conditions.cmd_mm;
    const ForwardResult nominal = forward(nominal_rails, cmd_mm, r.target);  // which is near
    const ForwardResult simulated = is_geometry ? forward(rails, cmd_mm, r.target)
                                                : believed(correction, mechanism, r.conditions);
    if (!nominal.ok() || !simulated.ok()) {
      throw InputError({.what = "the command of this reading cannot be simulated",
                        .where = {.point = "seq " + std::to_string(r.seq)},
                        .expected = "displacements within the robot's reach"});
    }
    errors.push_back({.target = r.target,
                      .measured = pose_difference(*r.measured, nominal.pose),
                      .simulated = pose_difference(simulated.pose, nominal.pose)});
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
