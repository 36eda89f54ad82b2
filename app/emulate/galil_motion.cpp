// What the controller does with its axes: begins, limits, stops, and what ends them.

#include <cmath>
#include <limits>

#include "app/emulate/galil.hpp"

namespace trammel::emulate {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kJogFault_s = 1;  // a jog has no middle: a fault befalls it after this time

/// Where the motor is, at rest; what is jammed or not there stays so.
Motion resting(const Motion& motion, double now_s) {
  const Motion rest = Motion::at_rest(std::nearbyint(motion.at(now_s).actual()));
  return motion.is_blocked() ? rest.blocked(now_s) : rest;
}

}  // namespace

void Galil::update() {
  const double now = now_s();
  for (Axis& a : axes_) {
    if (!a.running || now < a.motion.end_s()) continue;
    a.running = false;
    a.stop_code = a.ends_with;
    if (a.ends_off) {
      a.off = true;
      a.amplifier_fault |= a.ends_with == kAmplifierFault;
    }
    if (a.ends_with == kHomed) {
      a.zero = a.motion.at(now).commanded;
      a.target = 0;
    }
    if (a.next == Next::home || a.next == Next::index) a.next = Next::position;
  }
}

void Galil::put(Axis& a, const Motion& motion) {
  a.motion = motion;
  if (a.rail >= 0) robot_.change(a.rail, motion);
}

int Galil::on_switch(const Axis& a) const {
  if (a.rail < 0) return 0;
  if (a.phantom != 0 && now_s() >= a.phantom_s) return a.phantom;
  const EmulatedRobot::Switches ends = robot_.switches(a.rail);
  const double at = std::nearbyint(a.motion.at(now_s()).actual());
  return at >= ends.forward ? 1 : at <= ends.reverse ? -1 : 0;
}

/// The last count in this direction that is not beyond a limit, soft or hard.
Galil::Limit Galil::limit_of(const Axis& a, int direction) const {
  const bool forward = direction > 0;
  const double soft = a.zero + (forward ? a.forward_soft : a.reverse_soft);
  Limit limit{soft, forward ? kForwardLimit : kReverseLimit};
  const bool enabled = (static_cast<int>(a.limits_disabled) & (forward ? 1 : 2)) == 0;
  if (a.rail < 0 || !enabled) return limit;
  const EmulatedRobot::Switches ends = robot_.switches(a.rail);
  limit.counts = forward ? std::min(soft, ends.forward - 1) : std::max(soft, ends.reverse + 1);
  return limit;
}

Motion Galil::planned(const Axis& a, double now) const {
  const Dynamics dynamics{a.speed, a.accel, a.decel};
  const double here = a.motion.at(now).commanded;
  switch (a.next) {
    case Next::jog:
      return a.motion.jog(a.jog_speed, dynamics, now);
    case Next::relative:
      return a.motion.to(here + a.relative, dynamics, now);
    case Next::home:
    case Next::index:
      return a.motion.to(0, dynamics, now);
    case Next::position:
      break;
  }
  return a.motion.to(a.zero + a.target, dynamics, now);
}

void Galil::check_begin(const Axis& a, double now) const {
  if (a.off) throw Refused{20};
  if (a.running) throw Refused{21};
  const Motion motion = planned(a, now);
  const int direction = motion.direction();
  if (direction == 0) return;
  const double beyond = (motion.at(now).commanded - limit_of(a, direction).counts) * direction;
  if (beyond > 0 || a.phantom == direction) throw Refused{22};
}

/// The motion with what stops it before its end: a limit, or a following error with off-on-error.
Motion Galil::limited(Axis& a, Motion motion, double now) const {
  const int direction = motion.direction();
  a.ends_with = a.next == Next::home || a.next == Next::index ? kHomed : kArrived;
  a.ends_off = false;
  if (direction == 0) return motion;
  const Limit limit = limit_of(a, direction);
  const bool passes = (motion.at(motion.end_s()).commanded - limit.counts) * direction > 0;
  double limit_s = kNever, error_s = kNever;  // from the start of the motion
  if (passes) limit_s = motion.reaches(limit.counts).value_or(0);
  if (motion.is_blocked() && (static_cast<int>(a.off_on_error) & 1) != 0) {
    const double stands = motion.at(now).actual();
    error_s = motion.reaches(stands + direction * (a.error_limit + 1)).value_or(kNever);
  }
  if (error_s < limit_s) {
    a.ends_with = kErrorLimit;
    a.ends_off = true;
    return motion.cut(error_s);
  }
  if (!passes) return motion;
  a.ends_with = limit.code;
  return motion.stopped(limit_s, a.decel);
}

/// Faults on command befall the first axis that really moves.
void Galil::strike(Axis& a, Motion& motion, double now) {
  const int direction = motion.direction();
  const double whole_s = motion.duration_s();
  const double middle_s = std::isfinite(whole_s) ? 0.5 * whole_s : kJogFault_s;
  if (faults_.strikes(FaultKind::stall)) {
    motion = limited(a, motion.blocked(now), now);
  }
  if (faults_.strikes(FaultKind::limit_hit)) {
    a.phantom = direction;
    a.phantom_s = now + middle_s;
    a.ends_with = direction > 0 ? kForwardLimit : kReverseLimit;
    a.ends_off = false;
    motion = motion.stopped(middle_s, a.decel);
  }
  if (faults_.strikes(FaultKind::amplifier_fault)) {
    a.ends_with = kAmplifierFault;
    a.ends_off = true;
    motion = motion.cut(middle_s);
  }
}

void Galil::begin(const std::vector<int>& axes) {
  const double now = now_s();
  for (const int index : axes) check_begin(axis(index), now);  // all of them or none
  std::vector<EmulatedRobot::Start> starts;
  bool struck = false;
  for (const int index : axes) {
    Axis& a = axis(index);
    Motion motion = limited(a, planned(a, now), now);
    const bool goes = motion.direction() != 0;
    if (goes) a.phantom = 0;
    if (goes && a.rail >= 0 && !struck) strike(a, motion, now);
    struck |= goes && a.rail >= 0;
    a.running = true;  // one that goes nowhere has arrived when somebody looks
    a.stop_code = kRunning;
    a.motion = motion;
    const bool homes = a.ends_with == kHomed;
    if (a.rail >= 0 && (goes || homes)) starts.push_back({a.rail, motion, homes});
  }
  robot_.begin(starts);
}

void Galil::stop(int index) {
  Axis& a = axis(index);
  if (!a.running) return;
  put(a, a.motion.stopped(now_s() - a.motion.start_s(), a.decel));
  a.ends_with = kStopped;
  a.ends_off = false;
}

void Galil::abort() {
  for (Axis& a : axes_) {
    if (!a.running) continue;
    put(a, a.motion.aborted(now_s() - a.motion.start_s()));
    a.ends_with = kAborted;
    a.ends_off = false;
  }
}

void Galil::motor(int index, bool on) {
  Axis& a = axis(index);
  if (a.running) throw Refused{7};
  a.off = !on;
  a.amplifier_fault = false;
  const bool freed = a.rail >= 0;  // whoever takes the power off also clears a jam
  put(a, freed ? Motion::at_rest(resting(a.motion, now_s()).at(now_s()).actual())
               : resting(a.motion, now_s()));
}

void Galil::define_position(int index, double counts) {
  Axis& a = axis(index);
  if (a.running) throw Refused{7};
  put(a, resting(a.motion, now_s()));
  a.zero = a.motion.at(now_s()).commanded - counts;
  a.target = counts;
}

}  // namespace trammel::emulate
