#include "core/calibrate/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/units.hpp"

namespace trammel {

namespace {

double frame_scale(int index) { return index == 2 ? kFrameToleranceRad : kFrameToleranceMm; }

}  // namespace

namespace {

void add_frame(std::vector<FreeParameter>& all, int epoch, int coordinate) {
  const char* names[] = {"frame x", "frame y", "frame phi"};
  all.push_back({FreeParameter::Kind::epoch_frame, epoch, coordinate, frame_scale(coordinate),
                 names[coordinate] + (" of epoch " + std::to_string(epoch)),
                 coordinate == 2 ? "deg" : "mm"});
}

}  // namespace

std::vector<FreeParameter> base_parameters(const Machine& nominal,
                                           const std::vector<Reading>& readings) {
  const MachineKind& kind = *nominal.kind;
  const auto& geometry = parameters_of(kind);
  std::vector<FreeParameter> all;
  for (std::size_t k = 0; k < geometry.size(); ++k) {
    const MachineParameter& p = geometry[k];
    const ChainValues& chain = nominal.chains[static_cast<std::size_t>(p.chain)];
    if (kind.chain->second_order != nullptr && kind.chain->second_order(chain, p.place)) continue;
    all.push_back({FreeParameter::Kind::geometry, 0, static_cast<int>(k), p.tolerance, p.name,
                   p.is_angle ? "deg" : "mm"});
  }
  std::set<int> epochs;
  for (const Reading& r : readings) epochs.insert(r.conditions.epoch);
  if (epochs.empty()) return all;
  if (kind.has_point_platform() && nominal.measured[2]) add_frame(all, *epochs.begin(), 2);
  epochs.erase(epochs.begin());  // the first defines zeros and frame
  for (const int epoch : epochs) {
    for (int i = 0; i < kind.n_chains; ++i) {
      all.push_back({FreeParameter::Kind::epoch_zero, epoch, i, kZeroToleranceMm,
                     "l_zero_" + std::to_string(i + 1) + " of epoch " + std::to_string(epoch),
                     "mm"});
    }
    for (int i = 0; i < 3; ++i) add_frame(all, epoch, i);
  }
  return all;
}

void add_effect_parameters(std::vector<FreeParameter>& parameters, const RobotModel& model) {
  for (std::size_t owner = 0; owner < model.effects.size(); ++owner) {
    const ActiveEffect& active = model.effects[owner];
    const auto carries = [&active](int k) {
      return active.values[k] != 0 && !is_shape(*active.effect, k);
    };
    bool any = false;  // else its shape changes nothing
    for (int k = 0; k < active.values.size(); ++k) any = any || carries(k);
    for (int k = 0; k < active.values.size(); ++k) {
      const bool free =
          active.effect->parameters[static_cast<std::size_t>(k)].on == On::shape ? any : carries(k);
      if (!free) continue;
      const EffectParameter& p = active.effect->parameters[static_cast<std::size_t>(k)];
      parameters.push_back({FreeParameter::Kind::effect, static_cast<int>(owner), k, p.usual_max,
                            active.effect->name + " " + p.name, p.unit});
    }
  }
}

std::vector<ScaledParameter> scaled_parameters(const std::vector<FreeParameter>& parameters) {
  std::vector<ScaledParameter> scaled;
  for (const FreeParameter& p : parameters) {
    const bool effect = p.kind == FreeParameter::Kind::effect;
    scaled.push_back({p.name, !effect && p.unit == "deg", p.scale, effect ? p.unit : ""});
  }
  return scaled;
}

RobotModel moved(RobotModel model, const std::vector<FreeParameter>& parameters,
                 const Eigen::VectorXd& step) {
  const auto& geometry = parameters_of(*model.machine.kind);
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    const FreeParameter& p = parameters[j];
    const double d = p.scale * step[static_cast<Eigen::Index>(j)];
    if (p.kind == FreeParameter::Kind::geometry) {
      const MachineParameter& of = geometry[static_cast<std::size_t>(p.index)];
      model.machine.chains[static_cast<std::size_t>(of.chain)][of.place] += d;
    } else if (p.kind == FreeParameter::Kind::epoch_zero) {
      model.epochs[p.owner].l_zero_mm[p.index] += d;
    } else if (p.kind == FreeParameter::Kind::epoch_frame) {
      Pose& frame = model.epochs[p.owner].frame;
      frame = Pose::from(frame.vector() + d * Eigen::Vector3d::Unit(p.index));
    } else {
      ActiveEffect& active = model.effects[static_cast<std::size_t>(p.owner)];
      double& value = active.values[p.index];
      // a length or time stays positive, and no step takes it farther than e-fold
      value = is_shape(*active.effect, p.index) ? value * std::exp(std::clamp(d / value, -1.0, 1.0))
                                                : value + d;
    }
  }
  return model;
}

Eigen::Matrix3Xd derivative(const RobotModel& model, const std::vector<FreeParameter>& parameters,
                            const Conditions& conditions, const Prediction& at,
                            const Eigen::Vector3d& weight) {
  Eigen::Matrix3Xd J(3, static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    const FreeParameter& p = parameters[j];
    Eigen::Vector3d d = Eigen::Vector3d::Zero();
    if (p.held) {
    } else if (p.kind == FreeParameter::Kind::geometry) {
      d = at.J_e.col(p.index);
    } else if (p.kind == FreeParameter::Kind::effect) {
      const ActiveEffect& active = model.effects[static_cast<std::size_t>(p.owner)];
      if (recorded(*active.effect, at.moment))
        d = response(at, derivative_of(model, active, conditions, at.moment, p.index));
    } else if (p.owner == conditions.epoch) {
      if (p.kind == FreeParameter::Kind::epoch_zero) {
        d = at.J_e.col(at.columns->zero[static_cast<std::size_t>(p.index)]);
      } else {
        d[p.index] = 1;
        if (p.index == 2) d.head<2>() << -at.pose.y_mm, at.pose.x_mm;  // turned about O_A
      }
    }
    d *= p.scale;
    J.col(static_cast<Eigen::Index>(j)) = weight.cwiseProduct(d);
  }
  return J;
}

}  // namespace trammel
