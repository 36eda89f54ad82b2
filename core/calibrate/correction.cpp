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
constexpr double kStandingMm = 1e-9;  // a shorter move has no direction
constexpr double kPhiLengthMm = 100;

Eigen::Vector3d signs(const Displacements& move) {
  return move.unaryExpr([](double d) {
    return d > kStandingMm ? 1.0 : d < -kStandingMm ? -1.0 : 0.0;
  });
}

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
  InverseResult at = inverse(model.geometry, target);
  if (!at.ok()) return at;
  const Eigen::Vector3d forced(move.approach[0], move.approach[1], move.approach[2]);
  const auto direction = [&](const Displacements& cmd) -> Eigen::Vector3d {
    return (forced.array() != 0).select(forced, signs(cmd - move.from_mm));
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

/// The pose to ask the model for so that the map's joint errors are made up for.
ForwardResult shifted(const Mechanism& mechanism, const JointMap& left, const Pose& target,
                      double sign) {
  const InverseResult at = inverse(mechanism.geometry, target);
  if (!at.ok()) return failed(at);
  return forward(mechanism.geometry, at.l_mm + sign * joint_error_at(left, place_of(target)),
                 target);
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
  const auto map = [&](const MapCorrection& c) {
    InverseResult at = inverse(mechanism.geometry, move.target);
    if (at.ok()) at.l_mm -= joint_error_at(c.map, place_of(move.target));
    return at;
  };
  const auto model = [&](const ModelCorrection& c) {
    return commanded_by_model(c.model, move, move.target);
  };
  const auto hybrid = [&](const HybridCorrection& c) {
    const ForwardResult goal = shifted(mechanism, c.left, move.target, -1);
    if (!goal.ok()) return inverse(mechanism.geometry, move.target);
    return commanded_by_model(c.model, move, goal.pose);
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
    const ForwardResult at = forward(mechanism.geometry, conditions.cmd_mm, mechanism.home);
    if (!at.ok()) return at;
    const Displacements driven = conditions.cmd_mm + joint_error_at(c.map, place_of(at.pose));
    return forward(mechanism.geometry, driven, at.pose);
  };
  const auto model = [&](const ModelCorrection& c) {
    return as_forward(predict(c.model, conditions));
  };
  const auto hybrid = [&](const HybridCorrection& c) {
    const Prediction at = predict(c.model, conditions);
    return at.ok() ? shifted(mechanism, c.left, at.pose, 1) : as_forward(at);
  };
  return std::visit(Overloaded{nominal, geometry, map, model, hybrid}, correction);
}

std::vector<JointSample> samples_left(const RobotModel& model, std::span<const Reading> readings) {
  std::vector<JointSample> samples;
  const RailFrames nominal = rail_frames(model.mechanism.geometry);
  for (const Reading& r : readings) {
    const Prediction at = predict(model, r.conditions);
    const InverseResult thought = inverse(model.mechanism.geometry, at.pose);
    if (!at.ok() || !thought.ok()) {
      throw InputError({.what = "the model cannot reach the commanded displacements of a reading",
                        .where = {.point = "seq " + std::to_string(r.seq)}});
    }
    const Eigen::Vector3d all = joint_error_mm(nominal, r);
    samples.push_back({r.target.x_mm, r.target.y_mm, all - (thought.l_mm - r.conditions.cmd_mm)});
  }
  return samples;
}

std::vector<std::optional<Pose>> predicted_after(const Correction& correction,
                                                 const Mechanism& mechanism,
                                                 std::span<const Reading> readings) {
  const RailFrames nominal = rail_frames(mechanism.geometry);
  const auto* identified = std::get_if<GeometryCorrection>(&correction);
  const RailFrames rails = identified ? rail_frames(identified->geometry) : nominal;
  const auto command_mm = [&](const Reading& r) -> std::optional<Displacements> {
    if (identified) return inverse_displacements(rails, r.target);  // the same without angles
    const InverseResult at = commanded(correction, mechanism, move_of(r));
    return at.ok() ? std::optional(at.l_mm) : std::nullopt;
  };
  std::vector<std::size_t> reached;  // targets of these readings
  std::vector<Displacements> l_mm;
  std::vector<Pose> poses;
  reached.reserve(readings.size());
  l_mm.reserve(readings.size());
  poses.reserve(readings.size());
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const Reading& r = readings[k];
    const Eigen::Vector3d error_mm = joint_error_mm(nominal, r);
    const std::optional<Displacements> cmd_mm = command_mm(r);
    if (!cmd_mm) continue;
    reached.push_back(k);
    l_mm.emplace_back(*cmd_mm + error_mm);
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
