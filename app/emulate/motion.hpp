#pragma once
// The time law of one servo axis: what the controller commands and where the motor is, as a
// function of time. Everything is in counts and seconds, known when the motion begins.

#include <optional>
#include <vector>

namespace trammel::emulate {

struct Dynamics {
  double speed = 25000;   // counts/s
  double accel = 256000;  // counts/s^2
  double decel = 256000;  // counts/s^2
};

struct MotorState {
  double commanded = 0;  // counts
  double velocity = 0;   // of the command, counts/s
  double lag = 0;        // commanded - actual, counts: the following error
  [[nodiscard]] double actual() const { return commanded - lag; }
};

/// Phases of constant acceleration, the last of them for ever. The motor follows its command as a
/// first-order lag of kServoLag_s, solved exactly phase by phase:
///   r(t) = r + v t + a t^2 / 2,   e' = r' - e / T
///   e(t) = T (v + a t) - a T^2 + (e - T v + a T^2) exp(-t / T)                              (1)
/// A blocked motor stays where it was blocked. Proof: motion_test.cpp integrates (1) numerically.
class Motion {
 public:
  static constexpr double kServoLag_s = 0.010;

  static Motion at_rest(double counts);

  /// From here, at rest, to `target`: a trapezoid, or a triangle where the way is short.
  [[nodiscard]] Motion to(double target, const Dynamics& dynamics, double now_s) const;
  /// Up to the speed, its sign the direction, and on until stopped.
  [[nodiscard]] Motion jog(double speed, const Dynamics& dynamics, double now_s) const;

  // The same for `t` seconds from its start, which may lie ahead, and then:

  /// slows down, to rest on a whole count;
  [[nodiscard]] Motion stopped(double t, double decel) const;
  /// the command stands still at once, and the motor catches up;
  [[nodiscard]] Motion aborted(double t) const;
  /// without power the motor stays where it is, on a whole count, and the command with it.
  [[nodiscard]] Motion cut(double t) const;

  /// The motor stays where it is at `at_s`, whatever is commanded.
  [[nodiscard]] Motion blocked(double at_s) const;
  [[nodiscard]] bool is_blocked() const { return blocked_at_.has_value(); }

  [[nodiscard]] MotorState at(double now_s) const;
  /// When the command comes to rest; infinite for a jog.
  [[nodiscard]] double end_s() const { return start_s_ + duration_s(); }
  /// The same from the start of the motion: its bits do not depend on when that was.
  [[nodiscard]] double duration_s() const;
  [[nodiscard]] double start_s() const { return start_s_; }
  /// +1, -1, or 0 where it goes nowhere.
  [[nodiscard]] int direction() const;
  /// Until the command rests and the motor is within half a count, all an encoder can tell.
  [[nodiscard]] bool moving(double now_s) const;
  /// When, from the start of the motion, the command first stands at `counts`, if ever.
  [[nodiscard]] std::optional<double> reaches(double counts) const;

 private:
  struct Phase {
    double t = 0;                // from the start of the motion, s
    double r = 0, v = 0, a = 0;  // command at the phase's start: counts, counts/s, counts/s^2
    double e = 0;                // lag there, counts
  };
  static Motion from(const Motion& before, double now_s);
  [[nodiscard]] MotorState after(double t) const;
  [[nodiscard]] Motion until(double t) const;
  void append(double duration_s, double accel);

  double start_s_ = 0;
  std::vector<Phase> phases_;  // never empty; the last lasts for ever
  std::optional<double> blocked_at_;
};

}  // namespace trammel::emulate
