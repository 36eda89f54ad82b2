#include "core/calibrate/correction.hpp"

#include "core/calibrate/joint_error.hpp"

namespace trammel {

namespace {

template <class... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};

Place place_of(const Pose& pose) { return {pose.x_mm, pose.y_mm}; }

ForwardResult failed(const InverseResult& at) {
  ForwardResult result;
  result.status = ForwardResult::Status::unreachable;
  result.chain = at.chain;
  return result;
}

}  // namespace

std::string kind_of(const Correction& correction) {
  return std::visit(Overloaded{[](const NominalCorrection&) { return "nominal"; },
                               [](const GeometryCorrection&) { return "geometry"; },
                               [](const MapCorrection&) { return "map"; }},
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
  return std::visit(Overloaded{nominal, geometry, map}, correction);
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
  return std::visit(Overloaded{nominal, geometry, map}, correction);
}

ForwardResult predicted_after(const Correction& correction, const Mechanism& mechanism,
                              const Reading& reading) {
  const Eigen::Vector3d error_mm = joint_error_mm(mechanism, reading);
  const InverseResult cmd = commanded(correction, mechanism, move_of(reading));
  if (!cmd.ok()) return failed(cmd);
  return forward(mechanism.geometry, cmd.l_mm + error_mm, *reading.measured);
}

}  // namespace trammel
