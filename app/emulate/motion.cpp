#include "app/emulate/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trammel::emulate {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double sign_of(double value) { return value < 0 ? -1.0 : 1.0; }

}  // namespace

Motion Motion::at_rest(double counts) {
  Motion motion;
  motion.start_s_ = -kInfinity;
  motion.phases_.push_back({.r = counts});
  return motion;
}

MotorState Motion::at(double now_s) const { return after(std::max(now_s - start_s_, 0.0)); }

MotorState Motion::after(double t) const {
  const auto next = std::find_if(phases_.begin() + 1, phases_.end(),
                                 [t](const Phase& phase) { return phase.t > t; });
  const Phase& p = *(next - 1);
  MotorState state{.commanded = p.r, .velocity = p.v, .lag = p.e};
  t -= p.t;
  if (p.v != 0) state.commanded += p.v * t;
  if (p.a != 0) {
    state.commanded += 0.5 * p.a * t * t;
    state.velocity += p.a * t;
  }
  constexpr double T = kServoLag_s;
  const double forced = T * state.velocity - p.a * T * T;
  state.lag = forced + (p.e - T * p.v + p.a * T * T) * std::exp(-t / T);  // (1)
  if (blocked_at_) state.lag = state.commanded - *blocked_at_;
  return state;
}

void Motion::append(double duration_s, double accel) {
  const double t = phases_.back().t + duration_s;
  const MotorState then = after(t);
  phases_.push_back({t, then.commanded, then.velocity, accel, then.lag});
}

Motion Motion::from(const Motion& before, double now_s) {
  const MotorState here = before.at(now_s);
  Motion motion;
  motion.start_s_ = now_s;
  motion.blocked_at_ = before.blocked_at_;
  motion.phases_.push_back({.r = here.commanded, .e = here.lag});
  return motion;
}

Motion Motion::to(double target, const Dynamics& dynamics, double now_s) const {
  Motion motion = from(*this, now_s);
  const double way = target - motion.phases_.back().r, sign = sign_of(way);
  if (way == 0) return motion;
  const double ac = dynamics.accel, dc = dynamics.decel, length = std::abs(way);
  const double peak = std::min(dynamics.speed, std::sqrt(2 * length * ac * dc / (ac + dc)));
  const double cruise = std::max(length - peak * peak / (2 * ac) - peak * peak / (2 * dc), 0.0);
  motion.phases_.back().a = sign * ac;
  motion.append(peak / ac, 0);
  motion.append(cruise / peak, -sign * dc);
  motion.append(peak / dc, 0);
  motion.phases_.back().r = target;  // a sum of roundings is not where it was sent
  motion.phases_.back().v = 0;
  return motion;
}

Motion Motion::jog(double speed, const Dynamics& dynamics, double now_s) const {
  Motion motion = from(*this, now_s);
  if (speed == 0) return motion;
  motion.phases_.back().a = sign_of(speed) * dynamics.accel;
  motion.append(std::abs(speed) / dynamics.accel, 0);
  motion.phases_.back().v = speed;
  return motion;
}

Motion Motion::until(double t) const {
  Motion motion = *this;
  const MotorState then = after(t);
  std::erase_if(motion.phases_, [t](const Phase& phase) { return phase.t >= t; });
  motion.phases_.push_back({t, then.commanded, then.velocity, 0, then.lag});
  return motion;
}

Motion Motion::stopped(double t, double decel) const {
  Motion motion = until(t);
  const Phase from = motion.phases_.back();
  const double way = from.v * from.v / (2 * decel);
  const double end = from.v < 0 ? std::floor(from.r - way) : std::ceil(from.r + way);
  const double length = std::abs(end - from.r);
  if (from.v != 0 && length > 0) {
    motion.phases_.back().a = -sign_of(from.v) * from.v * from.v / (2 * length);
    motion.append(2 * length / std::abs(from.v), 0);
  }
  motion.phases_.back().r = end;
  motion.phases_.back().v = 0;
  return motion;
}

Motion Motion::aborted(double t) const {
  Motion motion = until(t);
  Phase& rest = motion.phases_.back();
  const double actual = rest.r - rest.e;
  rest.r = std::nearbyint(rest.r);
  rest.v = 0;
  rest.e = rest.r - actual;
  return motion;
}

Motion Motion::cut(double t) const {
  Motion motion = until(t);
  Phase& rest = motion.phases_.back();
  rest = {.t = rest.t, .r = std::nearbyint(rest.r - rest.e)};
  return motion;
}

Motion Motion::blocked(double at_s) const {
  Motion motion = *this;
  motion.blocked_at_ = std::nearbyint(at(at_s).actual());
  return motion;
}

double Motion::duration_s() const { return phases_.back().v == 0 ? phases_.back().t : kInfinity; }

int Motion::direction() const {
  const double a = phases_.front().a;
  return a > 0 ? 1 : a < 0 ? -1 : 0;
}

bool Motion::moving(double now_s) const {
  return now_s < end_s() || (!blocked_at_ && std::abs(at(now_s).lag) >= 0.5);
}

std::optional<double> Motion::reaches(double counts) const {
  for (std::size_t k = 0; k < phases_.size(); ++k) {
    const Phase& p = phases_[k];
    const double way = counts - p.r;
    if (way == 0) return p.t;
    const double squared = p.v * p.v + 2 * p.a * way;
    const double speed = p.v != 0 ? p.v : p.a;  // its sign is the direction of the phase
    if (speed * way <= 0 || squared < 0) continue;
    const double t = p.t + 2 * way / (p.v + sign_of(speed) * std::sqrt(squared));
    if (k + 1 == phases_.size() || t <= phases_[k + 1].t) return t;
  }
  return {};
}

}  // namespace trammel::emulate
