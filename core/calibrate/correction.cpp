#include "core/calibrate/correction.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibrate/joint_error.hpp"
#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/mechanism/poses.hpp"

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

constexpr int kMaxSteps = 40;
constexpr double kReached = 1e-10;    // mm, and rad times the platform's size
constexpr double kDirectionMm = 1.0;  // any length: a direction is a sign
constexpr double kPhiLengthMm = 100;

Conditions conditions_of(const Move& move, const Displacements& cmd, const Eigen::Vector3d& dir) {
  return {.cmd_mm = cmd,
          .from_mm = cmd - kDirectionMm * dir,
          .epoch = move.epoch,
          .time_s = move.time_s,
          .temp_degc = move.temp_degc};
}

/// Command that reads `target` with the directions held, from a first guess.
bool reach(const RobotModel& model, const Move& move, const Pose& target,
           const Eigen::Vector3d& dir, Displacements& cmd) {
  for (int step = 0; step < kMaxSteps; ++step) {
    const Prediction at = predict(model, conditions_of(move, cmd, dir));
    if (!at.ok()) return false;
    const Eigen::Vector3d missing = target.vector() - at.pose.vector();
    if (std::max(missing.head<2>().norm(), kPhiLengthMm * std::abs(missing[2])) <= kReached) {
      return true;
    }
    cmd += inverse(at.moment.J_V) * missing;
  }
  return false;
}

InverseResult commanded_by_model(const RobotModel& model, const Move& move, const Pose& target) {
  InverseResult at = inverse(model.geometry(), target);
  if (!at.ok()) return at;
  const Eigen::Vector3d forced(move.approach[0], move.approach[1], move.approach[2]);
  const auto direction = [&](const Displacements& cmd) -> Eigen::Vector3d {
    return (forced.array() != 0).select(forced, directions_of(cmd - move.from_mm));
  };
  const Displacements start = at.l_mm;
  Eigen::Vector3d dir = direction(start);
  for (int attempt = 0; attempt < 2; ++attempt) {
    Displacements cmd = start;
    if (!reach(model, move, target, dir, cmd)) {
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
std::optional<Eigen::Vector3d> error_under(const JointMap& map, const Mechanism& mechanism,
                                           const Displacements& cmd_mm, const Pose& near) {
  const ForwardResult at = forward(mechanism.geometry, cmd_mm, near);
  if (!at.ok()) return {};
  return joint_error_at(map, place_of(at.pose));
}

/// cmd = l(target) - e(forward(cmd)), by two look-ups: at the target, and where the first command
/// would stand. The next would change it by the square of the map's slope times e: 0.01 um where e
/// is 0.1 mm and changes by 1 % of the way.
InverseResult commanded_by_map(const MapCorrection& c, const Mechanism& mechanism,
                               const Move& move) {
  const EpochShift shift = shift_of(c.epochs, move.epoch);
  const Pose target = out_of_frame(shift.frame, move.target);
  InverseResult at = inverse(mechanism.geometry, target);
  if (!at.ok()) return at;
  const Displacements nominal = at.l_mm;
  at.l_mm = nominal - joint_error_at(c.map, place_of(target));
  const auto error_mm = error_under(c.map, mechanism, at.l_mm, target);
  if (error_mm) at.l_mm = nominal - *error_mm;
  at.l_mm -= shift.l_zero_mm;
  return at;
}

/// Displacements at which the nominal robot stands where this one does under `conditions`.
Displacements driven_by_map(const MapCorrection& c, const Mechanism& mechanism,
                            const Conditions& conditions, const Pose& near) {
  const EpochShift shift = shift_of(c.epochs, conditions.epoch);
  const Displacements cmd_mm = conditions.cmd_mm + shift.l_zero_mm;
  const auto error_mm = error_under(c.map, mechanism, cmd_mm, near);
  return cmd_mm + (error_mm ? *error_mm : joint_error_at(c.map, place_of(near)));
}

/// `pose` as the nominal robot would stand with its joints moved on by `by_mm`.
ForwardResult moved_on(const Mechanism& mechanism, const Pose& pose, const Displacements& by_mm) {
  const InverseResult at = inverse(mechanism.geometry, pose);
  if (!at.ok()) return failed(at);
  return forward(mechanism.geometry, at.l_mm + by_mm, pose);
}

/// The model is asked for the pose that the map's errors, looked up where the model's own command
/// for the target stands, turn into the target.
InverseResult commanded_by_hybrid(const HybridCorrection& c, const Mechanism& mechanism,
                                  const Move& move) {
  const InverseResult first = commanded_by_model(c.model, move, move.target);
  if (!first.ok()) return first;
  const auto error_mm = error_under(c.left, mechanism, first.l_mm, move.target);
  if (!error_mm) return first;
  const ForwardResult goal = moved_on(mechanism, move.target, -*error_mm);
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

Move move_of(const Reading& reading) {
  const Conditions& c = reading.conditions;
  return {.target = reading.target,
          .from_mm = c.from_mm,
          .epoch = c.epoch,
          .time_s = c.time_s,
          .temp_degc = c.temp_degc};
}

InverseResult commanded(const Correction& correction, const Mechanism& mechanism,
                        const Move& move) {
  const auto nominal = [&](const NominalCorrection&) {
    return inverse(mechanism.geometry, move.target);
  };
  const auto geometry = [&](const GeometryCorrection& c) {
    return inverse(c.geometry, move.target);
  };
  const auto map = [&](const MapCorrection& c) { return commanded_by_map(c, mechanism, move); };
  const auto model = [&](const ModelCorrection& c) {
    return commanded_by_model(c.model, move, move.target);
  };
  const auto hybrid = [&](const HybridCorrection& c) {
    return commanded_by_hybrid(c, mechanism, move);
  };
  return std::visit(Overloaded{nominal, geometry, map, model, hybrid}, correction);
}

ForwardResult believed(const Correction& correction, const Mechanism& mechanism,
                       const Conditions& conditions) {
  const auto nominal = [&](const NominalCorrection&) {
    return forward(mechanism.geometry, conditions.cmd_mm, mechanism.home);
  };
  const auto geometry = [&](const GeometryCorrection& c) {
    return forward(c.geometry, conditions.cmd_mm, mechanism.home);
  };
  const auto map = [&](const MapCorrection& c) {
    ForwardResult at =
        forward(mechanism.geometry, driven_by_map(c, mechanism, conditions, mechanism.home),
                mechanism.home);
    at.pose = in_frame(shift_of(c.epochs, conditions.epoch).frame, at.pose);
    return at;
  };
  const auto model = [&](const ModelCorrection& c) {
    return as_forward(predict(c.model, conditions));
  };
  const auto hybrid = [&](const HybridCorrection& c) {
    const Prediction at = predict(c.model, conditions);
    if (!at.ok()) return as_forward(at);
    const auto error_mm = error_under(c.left, mechanism, conditions.cmd_mm, at.pose);
    return error_mm ? moved_on(mechanism, at.pose, *error_mm) : ForwardResult{};
  };
  return std::visit(Overloaded{nominal, geometry, map, model, hybrid}, correction);
}

std::vector<JointSample> samples_left(const RobotModel& model, std::span<const Reading> readings) {
  std::vector<JointSample> samples;
  const Geometry nominal_geometry = geometry_of(model.nominal);
  const RailFrames nominal = rail_frames(nominal_geometry);
  for (const Reading& r : readings) {
    const Prediction at = predict(model, r.conditions);
    const InverseResult thought = inverse(nominal_geometry, at.pose);
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

/// Rails whose inverse kinematics decide whether the corrected robot reaches a target.
Geometry geometry_of(const Correction& correction, const Mechanism& mechanism) {
  return std::visit(
      Overloaded{[](const GeometryCorrection& c) -> Geometry { return c.geometry; },
                 [](const ModelCorrection& c) -> Geometry { return c.model.geometry(); },
                 [](const HybridCorrection& c) -> Geometry { return c.model.geometry(); },
                 [&](const auto&) -> Geometry { return mechanism.geometry; }},
      correction);
}

/// l(X_expected), nominal, of the poses that the correction expected of the readings under the
/// conditions they were taken in; nothing where it has none.
std::vector<std::optional<Displacements>> expected_mm(const Correction& correction,
                                                      const Mechanism& mechanism,
                                                      const RailFrames& nominal,
                                                      std::span<const Reading> readings) {
  std::vector<std::optional<Displacements>> expected(readings.size());
  if (const auto* identified = std::get_if<GeometryCorrection>(&correction)) {  // side by side
    std::vector<Displacements> l_mm;
    std::vector<Pose> poses;
    for (const Reading& r : readings) {
      l_mm.push_back(r.conditions.cmd_mm);
      poses.push_back(r.target);
    }
    auto missed = poses_at(rail_frames(identified->geometry), l_mm, poses);
    for (std::size_t k = 0; k < readings.size(); ++k) {
      if (std::ranges::find(missed, k) != missed.end()) continue;
      expected[k] = inverse_displacements(nominal, poses[k]);
    }
    return expected;
  }
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const Reading& r = readings[k];
    if (const auto* map = std::get_if<MapCorrection>(&correction)) {  // whose errors are of joints
      expected[k] = driven_by_map(*map, mechanism, r.conditions, r.target);
      if (!map->epochs.contains(r.conditions.epoch)) continue;
      const ForwardResult at = forward(nominal, *expected[k], r.target);
      const Pose frame = shift_of(map->epochs, r.conditions.epoch).frame;
      expected[k] = at.ok() ? inverse_displacements(nominal, in_frame(frame, at.pose))
                            : std::optional<Displacements>();
      continue;
    }
    const ForwardResult at = believed(correction, mechanism, r.conditions);
    if (at.ok()) expected[k] = inverse_displacements(nominal, at.pose);
  }
  return expected;
}

}  // namespace

std::vector<std::optional<Pose>> predicted_after(const Correction& correction,
                                                 const Mechanism& mechanism,
                                                 std::span<const Reading> readings) {
  const RailFrames nominal = rail_frames(mechanism.geometry);
  const RailFrames rails = rail_frames(geometry_of(correction, mechanism));
  const auto expected = expected_mm(correction, mechanism, nominal, readings);
  std::vector<std::size_t> reached;  // targets of these readings
  std::vector<Displacements> l_mm;
  std::vector<Pose> poses;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const Reading& r = readings[k];
    const Displacements measured_mm = joint_error_mm(nominal, r) + r.conditions.cmd_mm;
    const auto target_mm = inverse_displacements(nominal, r.target);
    if (!target_mm || !expected[k] || !inverse_displacements(rails, r.target)) continue;
    reached.push_back(k);
    l_mm.emplace_back(*target_mm + (measured_mm - *expected[k]));
    poses.push_back(*r.measured);
  }
  std::vector<std::optional<Pose>> after(readings.size());
  const std::vector<std::size_t> missed = poses_at(nominal, l_mm, poses);
  for (std::size_t j = 0; j < reached.size(); ++j) after[reached[j]] = poses[j];
  for (const std::size_t j : missed) after[reached[j]] = {};
  return after;
}

std::optional<Pose> predicted_after(const Correction& correction, const Mechanism& mechanism,
                                    const Reading& reading) {
  return predicted_after(correction, mechanism, std::span(&reading, 1)).front();
}

}  // namespace trammel
