#include "core/model/robot_model.hpp"

#include <algorithm>
#include <cmath>

#include "core/model/predictor.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

/// Along each passive guide, by the nominal chains.
void stand_on_guides(const Machine& nominal, const Displacements& home_mm, Moment& m) {
  const ChainKind& chain = *nominal.kind->chain;
  if (chain.on_guide == nullptr) {
    m.guide_mm = m.s_mm;
    return;
  }
  for (int i = 0; i < nominal.kind->n_chains; ++i) {
    const ChainValues& p = nominal.chains[static_cast<std::size_t>(i)];
    const OnGuide here = chain.on_guide(p, m.l_mm[i], m.pose);
    m.guide_mm[i] = here.along_mm - chain.on_guide(p, home_mm[i], nominal.home).along_mm;
    m.lever_mm[i] = here.lever_mm;
  }
}

Moment moment_under(const RobotModel& model, const Displacements& home_mm, const Conditions& at,
                    const MachineAt& found) {
  Moment m;
  m.l_mm = at.cmd_mm;
  m.s_mm = at.cmd_mm - home_mm;
  m.travel_mm = at.cmd_mm - at.from_mm;
  m.direction = directions_of(m.travel_mm);
  m.temp_degc = at.temp_degc;
  if (at.time_s) m.time_h = *at.time_s / kSecondsPerHour;
  for (std::size_t i = 0; i < kChains; ++i) {
    m.lead_mm[static_cast<Eigen::Index>(i)] = model.nominal.drives[i].lead_mm;
  }
  m.turns_with_axes = model.nominal.kind->has_point_platform();
  m.pose = found.pose;
  m.theta_rad = found.angle_rad;
  m.J_V = found.J_V;
  stand_on_guides(model.nominal, home_mm, m);
  for (const Effect& effect : effect_catalogue()) {
    if (effect.recall == nullptr) continue;
    const auto own = std::ranges::find(model.effects, &effect, &ActiveEffect::effect);
    effect.recall(m, own != model.effects.end() ? own->values : usual_shapes(effect), at,
                  model.history.get());
  }
  return m;
}

}  // namespace

RobotModel nominal_model(const Machine& machine) {
  return {.nominal = machine, .machine = machine, .epochs = {}, .effects = {}};
}

RobotModel nominal_model(const Mechanism& mechanism) {
  return nominal_model(machine_of(mechanism));
}

bool recorded(const Effect& effect, const Moment& moment) {
  for (const Need need : effect.needs) {
    if (need == Need::temperature && !moment.temp_degc) return false;
    if (need == Need::time && !moment.time_h) return false;
  }
  return true;
}

Predictor::Predictor(const RobotModel& model)
    : model_(model),
      solver_(model.machine),
      home_mm_(drives_of(model.nominal, model.nominal.home)) {}

Prediction Predictor::moment_of(const Conditions& conditions) const {
  const MachineKind& kind = *model_.nominal.kind;
  Prediction result;
  result.columns = &chain_columns(kind);
  result.J_e = ParameterColumns::Zero(3, std::ssize(parameters_of(kind)));
  const EpochShift shift = shift_of(model_.epochs, conditions.epoch);
  const MachineAt at = solver_.at(conditions.cmd_mm + shift.l_zero_mm, model_.nominal.home, true);
  result.status = at.status;
  if (!at.ok()) return result;
  result.pose = at.pose;
  result.moment = moment_under(model_, home_mm_, conditions, at);
  result.J_e = at.J_e;
  return result;
}

Prediction Predictor::predict(const Conditions& conditions) const {
  Prediction result = moment_of(conditions);
  if (!result.ok()) return result;
  Deviation sum;
  for (const ActiveEffect& active : model_.effects) {
    if (!recorded(*active.effect, result.moment)) continue;
    sum += deviation_of(active, result.moment);
  }
  const EpochShift shift = shift_of(model_.epochs, conditions.epoch);
  if (!model_.effects.empty()) {
    const Displacements l_mm = conditions.cmd_mm + shift.l_zero_mm + sum.dl_mm;
    const auto moved = [&] {
      MachineSolver bent = solver_;
      bent.move_guides(sum.dh_mm);
      return bent.at(l_mm, result.pose, false);
    };
    const MachineAt at = sum.dh_mm.isZero(0) ? solver_.at(l_mm, result.pose, false) : moved();
    result.status = at.status;
    if (!at.ok()) return result;
    result.pose = at.pose;
    result.J_e = at.J_e;
  }
  result.pose = Pose::from(in_frame(shift.frame, result.pose).vector() + sum.dX);
  return result;
}

Prediction moment_of(const RobotModel& model, const Conditions& conditions) {
  return Predictor(model).moment_of(conditions);
}

Prediction predict(const RobotModel& model, const Conditions& conditions) {
  return Predictor(model).predict(conditions);
}

Deviation deviation_of(const ActiveEffect& active, const Moment& moment) {
  Deviation sum;
  for (int k = 0; k < active.values.size(); ++k) {
    if (active.values[k] == 0 || is_shape(*active.effect, k)) continue;
    sum += active.values[k] * active.effect->basis(moment, k);
  }
  return sum;
}

Deviation derivative_of(const RobotModel& model, const ActiveEffect& active,
                        const Conditions& conditions, const Moment& moment, int k) {
  if (!is_shape(*active.effect, k)) return active.effect->basis(moment, k);
  constexpr double kStep = 1e-4;  // of the shape
  ActiveEffect longer = active, shorter = active;
  longer.values[k] *= 1 + kStep;
  shorter.values[k] *= 1 - kStep;
  Moment after = moment, before = moment;
  active.effect->recall(after, longer.values, conditions, model.history.get());
  active.effect->recall(before, shorter.values, conditions, model.history.get());
  Deviation d = deviation_of(longer, after);
  d += -1.0 * deviation_of(shorter, before);
  return 1 / (2 * kStep * active.values[k]) * d;
}

Eigen::Vector3d response(const Prediction& at, const Deviation& d) {
  Eigen::Vector3d dX = d.dX;
  for (int i = 0; i < kChains; ++i) {
    const auto chain = static_cast<std::size_t>(i);
    const int zero = at.columns->zero[chain], offset = at.columns->offset[chain];
    if (zero < 0) continue;
    Eigen::Vector3d follows = at.J_e.col(zero) * d.dl_mm[i];
    if (offset >= 0) follows += at.J_e.col(offset) * d.dh_mm[i];
    dX += follows;
  }
  return dX;
}

}  // namespace trammel
