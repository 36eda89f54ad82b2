#include "core/calibrate/correction.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibrate/joint_error.hpp"
#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/model/predictor.hpp"

namespace trammel {

namespace {

template <class... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};
template <class... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;

Place place_of(const Pose& pose) { return {pose.x_mm, pose.y_mm}; }

ForwardResult failed(const InverseResult& at) {
  ForwardResult result;
  result.status = ForwardResult::Status::unreachable;
  result.chain = at.chain;
  return result;
}

ForwardResult as_forward(const MachinePose& at) {
  ForwardResult result;
  result.status = at.ok()                                      ? ForwardResult::Status::ok
                  : at.status == MachinePose::Status::singular ? ForwardResult::Status::singular
                                                               : ForwardResult::Status::unreachable;
  result.pose = at.pose;
  result.chain = at.chain;
  return result;
}

/// The machine as it was identified.
Machine with_geometry(const NominalMachine& machine, const Geometry& geometry) {
  Machine built = machine.machine();
  set_geometry(built, geometry);
  return built;
}

constexpr int kMaxSteps = 40;         // a bound: it ends where the target is reached
constexpr double kReached = 1e-10;    // mm, and rad times the platform's size
constexpr double kDirectionMm = 1e6;  // so long that what shorter moves leave has faded
constexpr double kPhiLengthMm = 100;  // what a turn moves at this arm

Conditions conditions_of(const Move& move, const Displacements& cmd, const Eigen::Vector3d& dir) {
  return {.cmd_mm = cmd,
          .from_mm = cmd - kDirectionMm * dir,
          .epoch = move.epoch,
          .time_s = move.time_s,
          .temp_degc = move.temp_degc};
}

/// Command that reads `target` with the directions held, from a first guess.
bool reach(const Predictor& expected, const NominalMachine& built, const Move& move,
           const Pose& target, const Eigen::Vector3d& dir, Displacements& cmd) {
  for (int step = 0; step < kMaxSteps; ++step) {
    const Prediction at = expected.predict(conditions_of(move, cmd, dir));
    if (!at.ok()) return false;
    Eigen::Vector3d missing = target.vector() - at.pose.vector();
    // what the machine does not move, no command changes: a stage's parasitic angle
    for (int c = built.machine().kind->n_chains; c < 3; ++c) missing[c] = 0;
    if (std::max(missing.head<2>().norm(), kPhiLengthMm * std::abs(missing[2])) <= kReached) {
      return true;
    }
    cmd += inverse(built.invertible(at.moment.J_V)) * missing;
  }
  return false;
}

InverseResult commanded_by_model(const RobotModel& model, const Move& move, const Pose& target) {
  const NominalMachine built(model.machine);
  InverseResult at = built.drives(target);
  if (!at.ok()) return at;
  const Predictor expected(model);
  const Eigen::Vector3d forced(move.approach[0], move.approach[1], move.approach[2]);
  const auto direction = [&](const Displacements& cmd) -> Eigen::Vector3d {
    return (forced.array() != 0).select(forced, directions_of(cmd - move.from_mm));
  };
  const Displacements start = at.l_mm;
  Eigen::Vector3d dir = direction(start);
  for (int attempt = 0; attempt < 2; ++attempt) {
    Displacements cmd = start;
    if (!reach(expected, built, move, target, dir, cmd)) {
      at.status = InverseResult::Status::unreachable;
      return at;
    }
    at.l_mm = cmd;
    const Eigen::Vector3d real = direction(cmd);
    if (real == dir) break;
    dir = real;
  }
  return at;
}

/// The joint errors a map believes in where the nominal robot stands under `cmd_mm`: samples are
/// placed by their targets, the places of nominal commands.
std::optional<Eigen::Vector3d> error_under(const JointMap& map, const NominalMachine& machine,
                                           const Displacements& cmd_mm, const Pose& near) {
  const MachinePose at = machine.pose(cmd_mm, near);
  if (!at.ok()) return {};
  return joint_error_at(map, place_of(at.pose));
}

/// cmd = l(target) - e(forward(cmd)), by two look-ups: at the target, and where the first command
/// would stand. The next would change it by the square of the map's slope times e: 0.01 um where e
/// is 0.1 mm and changes by 1 % of the way.
InverseResult commanded_by_map(const MapCorrection& c, const NominalMachine& machine,
                               const Move& move) {
  const EpochShift shift = shift_of(c.epochs, move.epoch);
  const Pose target = out_of_frame(shift.frame, move.target);
  InverseResult at = machine.drives(target);
  if (!at.ok()) return at;
  const Displacements nominal = at.l_mm;
  at.l_mm = nominal - joint_error_at(c.map, place_of(target));
  const auto error_mm = error_under(c.map, machine, at.l_mm, target);
  if (error_mm) at.l_mm = nominal - *error_mm;
  at.l_mm -= shift.l_zero_mm;
  return at;
}

/// Displacements at which the nominal robot stands where this one does under `conditions`.
Displacements driven_by_map(const MapCorrection& c, const NominalMachine& machine,
                            const Conditions& conditions, const Pose& near) {
  const EpochShift shift = shift_of(c.epochs, conditions.epoch);
  const Displacements cmd_mm = conditions.cmd_mm + shift.l_zero_mm;
  const auto error_mm = error_under(c.map, machine, cmd_mm, near);
  return cmd_mm + (error_mm ? *error_mm : joint_error_at(c.map, place_of(near)));
}

/// `pose` as the nominal robot would stand with its joints moved on by `by_mm`.
ForwardResult moved_on(const NominalMachine& machine, const Pose& pose,
                       const Displacements& by_mm) {
  const InverseResult at = machine.drives(pose);
  if (!at.ok()) return failed(at);
  return as_forward(machine.pose(at.l_mm + by_mm, pose));
}

/// The model is asked for the pose that the map's errors, looked up where the model's own command
/// for the target stands, turn into the target.
InverseResult commanded_by_hybrid(const HybridCorrection& c, const NominalMachine& machine,
                                  const Move& move) {
  const InverseResult first = commanded_by_model(c.model, move, move.target);
  if (!first.ok()) return first;
  const auto error_mm = error_under(c.left, machine, first.l_mm, move.target);
  if (!error_mm) return first;
  const ForwardResult goal = moved_on(machine, move.target, -*error_mm);
  return goal.ok() ? commanded_by_model(c.model, move, goal.pose) : first;
}

ForwardResult as_forward(const Prediction& at) {
  ForwardResult result;
  result.status = at.status;
  result.pose = at.pose;
  return result;
}

}  // namespace

std::string kind_of(const Correction& correction) {
  return std::visit(Overloaded{[](const NominalCorrection&) { return "nominal"; },
                               [](const GeometryCorrection&) { return "geometry"; },
                               [](const MapCorrection&) { return "map"; },
                               [](const ModelCorrection&) { return "model"; },
                               [](const HybridCorrection&) { return "hybrid"; }},
                    correction);
}

EpochShifts* epochs_of(Correction& correction) {
  return std::visit(Overloaded{[](NominalCorrection&) -> EpochShifts* { return nullptr; },
                               [](GeometryCorrection&) -> EpochShifts* { return nullptr; },
                               [](MapCorrection& map) { return &map.epochs; },
                               [](ModelCorrection& model) { return &model.model.epochs; },
                               [](HybridCorrection& hybrid) { return &hybrid.model.epochs; }},
                    correction);
}

Move move_of(const Reading& reading) {
  const Conditions& c = reading.conditions;
  return {.target = reading.target,
          .from_mm = c.from_mm,
          .epoch = c.epoch,
          .time_s = c.time_s,
          .temp_degc = c.temp_degc};
}

InverseResult commanded(const Correction& correction, const NominalMachine& machine,
                        const Move& move) {
  const auto nominal = [&](const NominalCorrection&) { return machine.drives(move.target); };
  const auto geometry = [&](const GeometryCorrection& c) {
    return MachineSolver(with_geometry(machine, c.geometry)).drives(move.target);
  };
  const auto map = [&](const MapCorrection& c) { return commanded_by_map(c, machine, move); };
  const auto model = [&](const ModelCorrection& c) {
    return commanded_by_model(c.model, move, move.target);
  };
  const auto hybrid = [&](const HybridCorrection& c) {
    return commanded_by_hybrid(c, machine, move);
  };
  return std::visit(Overloaded{nominal, geometry, map, model, hybrid}, correction);
}

ForwardResult believed(const Correction& correction, const NominalMachine& machine,
                       const Conditions& conditions) {
  const Pose& home = machine.machine().home;
  const auto nominal = [&](const NominalCorrection&) {
    return as_forward(machine.pose(conditions.cmd_mm, home));
  };
  const auto geometry = [&](const GeometryCorrection& c) {
    return as_forward(
        MachineSolver(with_geometry(machine, c.geometry)).pose(conditions.cmd_mm, home));
  };
  const auto map = [&](const MapCorrection& c) {
    ForwardResult at = as_forward(machine.pose(driven_by_map(c, machine, conditions, home), home));
    at.pose = in_frame(shift_of(c.epochs, conditions.epoch).frame, at.pose);
    return at;
  };
  const auto model = [&](const ModelCorrection& c) {
    return as_forward(predict(c.model, conditions));
  };
  const auto hybrid = [&](const HybridCorrection& c) {
    const Prediction at = predict(c.model, conditions);
    if (!at.ok()) return as_forward(at);
    const auto error_mm = error_under(c.left, machine, conditions.cmd_mm, at.pose);
    return error_mm ? moved_on(machine, at.pose, *error_mm) : ForwardResult{};
  };
  return std::visit(Overloaded{nominal, geometry, map, model, hybrid}, correction);
}

std::vector<JointSample> samples_left(const RobotModel& model, std::span<const Reading> readings) {
  std::vector<JointSample> samples;
  const NominalMachine nominal(model.nominal);
  require_all_measured(nominal);
  const Predictor expected(model);
  for (const Reading& r : readings) {
    const Prediction at = expected.predict(r.conditions);
    const InverseResult thought = nominal.drives(at.pose);
    if (!at.ok() || !thought.ok()) {
      throw InputError({.what = "the model cannot reach the commanded displacements of a reading",
                        .where = {.point = "seq " + std::to_string(r.seq)}});
    }
    const Eigen::Vector3d all = joint_error_mm(nominal, r);
    samples.push_back({r.target.x_mm, r.target.y_mm, all - (thought.l_mm - r.conditions.cmd_mm)});
  }
  return samples;
}

namespace {

/// Whose inverse kinematics decide whether the corrected robot reaches a target.
Machine machine_of(const Correction& correction, const NominalMachine& machine) {
  return std::visit(
      Overloaded{[&](const GeometryCorrection& c) { return with_geometry(machine, c.geometry); },
                 [](const ModelCorrection& c) { return c.model.machine; },
                 [](const HybridCorrection& c) { return c.model.machine; },
                 [&](const auto&) { return machine.machine(); }},
      correction);
}

/// l(X_expected), nominal, of the poses that the correction expected of the readings under the
/// conditions they were taken in; nothing where it has none.
std::vector<std::optional<Displacements>> expected_mm(const Correction& correction,
                                                      const NominalMachine& machine,
                                                      std::span<const Reading> readings) {
  std::vector<std::optional<Displacements>> expected(readings.size());
  if (const auto* identified = std::get_if<GeometryCorrection>(&correction)) {  // side by side
    std::vector<Displacements> l_mm;
    std::vector<Pose> poses;
    for (const Reading& r : readings) {
      l_mm.push_back(r.conditions.cmd_mm);
      poses.push_back(r.target);
    }
    const auto missed =
        NominalMachine(with_geometry(machine, identified->geometry)).poses(l_mm, poses);
    for (std::size_t k = 0; k < readings.size(); ++k) {
      if (std::ranges::find(missed, k) != missed.end()) continue;
      expected[k] = machine.displacements(poses[k]);
    }
    return expected;
  }
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const Reading& r = readings[k];
    if (const auto* map = std::get_if<MapCorrection>(&correction)) {  // whose errors are of joints
      expected[k] = driven_by_map(*map, machine, r.conditions, r.target);
      if (!map->epochs.contains(r.conditions.epoch)) continue;
      const MachinePose at = machine.pose(*expected[k], r.target);
      const Pose frame = shift_of(map->epochs, r.conditions.epoch).frame;
      expected[k] = at.ok() ? machine.displacements(in_frame(frame, at.pose))
                            : std::optional<Displacements>();
      continue;
    }
    const ForwardResult at = believed(correction, machine, r.conditions);
    if (at.ok()) expected[k] = machine.displacements(at.pose);
  }
  return expected;
}

}  // namespace

std::vector<std::optional<Pose>> predicted_after(const Correction& correction,
                                                 const NominalMachine& machine,
                                                 std::span<const Reading> readings) {
  const NominalMachine rails(machine_of(correction, machine));
  const auto expected = expected_mm(correction, machine, readings);
  std::vector<std::size_t> reached;  // targets of these readings
  std::vector<Displacements> l_mm;
  std::vector<Pose> poses;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    Reading r = readings[k];
    if (!machine.measures_all() && r.measured && expected[k]) {
      // what is not measured is as expected, and comes out at the target
      const MachinePose stands = machine.pose(*expected[k], r.target);
      if (stands.ok()) r.measured = machine.measured_else(*r.measured, stands.pose);
    }
    const Displacements measured_mm = joint_error_mm(machine, r) + r.conditions.cmd_mm;
    const auto target_mm = machine.displacements(r.target);
    if (!target_mm || !expected[k] || !rails.displacements(r.target)) continue;
    reached.push_back(k);
    l_mm.emplace_back(*target_mm + (measured_mm - *expected[k]));
    poses.push_back(*r.measured);
  }
  std::vector<std::optional<Pose>> after(readings.size());
  const std::vector<std::size_t> missed = machine.poses(l_mm, poses);
  for (std::size_t j = 0; j < reached.size(); ++j) after[reached[j]] = poses[j];
  for (const std::size_t j : missed) after[reached[j]] = {};
  return after;
}

std::optional<Pose> predicted_after(const Correction& correction, const NominalMachine& machine,
                                    const Reading& reading) {
  return predicted_after(correction, machine, std::span(&reading, 1)).front();
}

}  // namespace trammel
