#include "core/model/robot_model.hpp"

#include <cmath>

#include "core/mechanism/velocity.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

Moment conditions_of(const RobotModel& model, const Conditions& at) {
  Moment m;
  m.l_mm = at.cmd_mm;
  m.s_mm = at.cmd_mm - inverse(model.mechanism.geometry, model.mechanism.home).l_mm;
  m.travel_mm = at.cmd_mm - at.from_mm;
  m.direction = directions_of(m.travel_mm);
  m.temp_degc = at.temp_degc;
  if (at.time_s) m.time_h = *at.time_s / kSecondsPerHour;
  m.screw_lead_mm = model.mechanism.screw_lead_mm;
  return m;
}

}  // namespace

RobotModel nominal_model(const Mechanism& mechanism) {
  return {.mechanism = mechanism, .geometry = mechanism.geometry, .epochs = {}, .effects = {}};
}

bool recorded(const Effect& effect, const Moment& moment) {
  for (const Need need : effect.needs) {
    if (need == Need::temperature && !moment.temp_degc) return false;
    if (need == Need::time && !moment.time_h) return false;
  }
  return true;
}

namespace {

Prediction moment_at(const RailFrames& rails, const RobotModel& model,
                     const Conditions& conditions) {
  Prediction result;
  const EpochShift shift = shift_of(model.epochs, conditions.epoch);
  const Displacements l_mm = conditions.cmd_mm + shift.l_zero_mm;
  const ForwardResult at = forward(rails, l_mm, model.mechanism.home);
  result.status = at.status;
  if (!at.ok()) return result;
  result.pose = at.pose;
  result.moment = conditions_of(model, conditions);
  result.moment.pose = at.pose;
  result.moment.theta_rad = link_angles_rad(rails, at.at);
  result.moment.J_V = velocity_jacobian(velocity_equation(rails, at.at));
  result.J_e = error_jacobian(rails, at.at);
  return result;
}

}  // namespace

Prediction moment_of(const RobotModel& model, const Conditions& conditions) {
  return moment_at(rail_frames(model.geometry), model, conditions);
}

Prediction predict(const RobotModel& model, const Conditions& conditions) {
  RailFrames rails = rail_frames(model.geometry);
  Prediction result = moment_at(rails, model, conditions);
  if (!result.ok()) return result;
  Deviation sum;
  for (const ActiveEffect& active : model.effects) {
    if (!recorded(*active.effect, result.moment)) continue;
    for (int k = 0; k < active.values.size(); ++k) {
      if (active.values[k] != 0) sum += active.values[k] * active.effect->basis(result.moment, k);
    }
  }
  const EpochShift shift = shift_of(model.epochs, conditions.epoch);
  if (!model.effects.empty()) {
    for (int i = 0; i < kChains; ++i) rails.h_mm[static_cast<std::size_t>(i)] += sum.dh_mm[i];
    const ForwardResult at =
        forward(rails, conditions.cmd_mm + shift.l_zero_mm + sum.dl_mm, result.pose);
    result.status = at.status;
    if (!at.ok()) return result;
    result.pose = at.pose;
    result.J_e = error_jacobian(rails, at.at);
  }
  result.pose = Pose::from(in_frame(shift.frame, result.pose).vector() + sum.dX);
  return result;
}

Eigen::Vector3d response(const Prediction& at, const Deviation& d) {
  Eigen::Vector3d dX = d.dX;
  for (int i = 0; i < kChains; ++i) {
    dX += at.J_e.col(6 * i + 4) * d.dl_mm[i] + at.J_e.col(kPaperParameters + i) * d.dh_mm[i];
  }
  return dX;
}

}  // namespace trammel
