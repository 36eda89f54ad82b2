#pragma once
// A Galil DMC-4183 as far as a campaign needs it: eight axes, of which A, B and C are wired to the
// rails of the emulated robot. README.md says what is modelled and what is not.

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/emulate/faults.hpp"
#include "app/emulate/robot.hpp"
#include "app/emulate/server.hpp"

namespace trammel::emulate {

inline constexpr int kAxes = 8;
inline constexpr std::size_t kMaxLine = 80;  // characters, compounds included

/// A command was answered with "?", for this reason of the TC table.
struct Refused {
  int code = 1;
};

/// "20 Begin not valid with motor off"; the code alone where the table has no words.
std::string error_text(int code);

/// What the next BG does.
enum class Next { position, relative, jog, home, index };

/// Why an axis does not move, as SC says it.
enum StopCode : int {
  kRunning = 0,
  kArrived = 1,
  kForwardLimit = 2,
  kReverseLimit = 3,
  kStopped = 4,
  kAborted = 7,
  kErrorLimit = 8,
  kHomed = 10,
  kAmplifierFault = 15,
};

/// Registers are in counts of the position register; motions in counts from the home switch.
struct Axis {
  int rail = -1;  // -1: nothing is wired to it, its encoder does not move
  Motion motion = Motion::at_rest(0);
  double zero = 0;  // motion's counts where the register says 0
  double speed = 25000, accel = 256000, decel = 256000;
  double home_speed = 256, jog_speed = 25000;
  double forward_soft = 2147483647.0, reverse_soft = -2147483648.0;
  double error_limit = 16384, off_on_error = 0, limits_disabled = 0;
  double kp = 6, ki = 0, kd = 64;
  double target = 0, relative = 0;  // of PA and PR, register counts
  Next next = Next::position;
  bool off = true;
  bool running = false;
  bool amplifier_fault = false;
  int phantom = 0;       // +1, -1: a limit switch that acts where no limit is,
  double phantom_s = 0;  // from this time on
  int stop_code = kArrived;
  int ends_with = kArrived;  // stop code of the motion that runs
  bool ends_off = false;     // and whether the motor loses its power with it
};

class Galil;

/// The program in the controller, and its threads. What it waits for (WT) is time of the wall,
/// whatever the emulated world's --speedup: a program that watches its host has the host's time.
/// Proof: tests/app/emulate/galil_program_test.cpp.
class Programs {
 public:
  static constexpr int kThreads = 8;

  explicit Programs(Galil& galil) : galil_(galil) {}

  /// In the place of what was there before, as DL takes it.
  void load(const std::vector<std::string>& lines);
  /// At the label ("#HOST"), at the beginning without one. Refused: 10, 11.
  void start(std::string_view label, int thread);
  void halt(int thread) { threads_.at(static_cast<std::size_t>(thread)).next.reset(); }
  /// The statement that comes next; -1: the thread does not run.
  [[nodiscard]] int place(int thread) const;
  [[nodiscard]] bool any_runs() const;

  /// Carries out what is due; of the server's `meanwhile`. Seconds until something is again,
  /// nothing where nothing runs.
  std::optional<double> work();

 private:
  using Clock = std::chrono::steady_clock;
  struct Thread {
    std::optional<std::size_t> next;  // of the statements
    Clock::time_point due = {};
  };
  void step(Thread& thread);
  [[nodiscard]] std::size_t labelled(std::string_view label) const;
  [[nodiscard]] bool holds(std::string_view condition);

  Galil& galil_;
  std::vector<std::string> statements_;
  std::array<Thread, kThreads> threads_;
};

/// The controller: one for all its connections. Used from one thread, its server's.
class Galil {
 public:
  Galil(EmulatedRobot& robot, Faults& faults);

  /// Carries out one line without its end and answers it: one prompt for each sub-command.
  std::string line(std::string_view text);
  /// What a line of more than kMaxLine characters gets.
  std::string line_too_long();

  /// A connection takes a handle, A to H, and gives it back.
  int attach(const Peer& peer);
  void detach(int handle);

  // For the commands, galil_*.cpp.
  [[nodiscard]] double now_s() const { return robot_.now_s(); }
  Axis& axis(int index) { return axes_.at(static_cast<std::size_t>(index)); }
  void begin(const std::vector<int>& axes);
  void stop(int axis);
  void abort();
  void motor(int axis, bool on);
  void define_position(int axis, double counts);
  /// +1: on the forward switch, -1: on the reverse one.
  [[nodiscard]] int on_switch(const Axis& axis) const;
  /// A number, an operand, a variable or an element of an array.
  [[nodiscard]] double value(std::string_view expression);
  [[nodiscard]] std::string handles_text() const;
  [[nodiscard]] std::string standing_text() const;

  int error = 0;        // TC
  bool echo = false;    // EO
  int unsolicited = 2;  // CW
  std::map<std::string, double, std::less<>> variables;
  std::map<std::string, std::vector<double>, std::less<>> arrays;
  Programs programs{*this};

 private:
  struct Limit {
    double counts = 0;
    int code = kForwardLimit;
  };
  std::string sub_command(std::string_view text);
  void update();  // what has ended by now
  void put(Axis& axis, const Motion& motion);
  [[nodiscard]] Limit limit_of(const Axis& axis, int direction) const;
  [[nodiscard]] Motion planned(const Axis& axis, double now_s) const;
  void check_begin(const Axis& axis, double now_s) const;
  Motion limited(Axis& axis, Motion motion, double now_s) const;
  void strike(Axis& axis, Motion& motion, double now_s);

  EmulatedRobot& robot_;
  Faults& faults_;
  std::array<Axis, kAxes> axes_;
  std::array<Peer, kAxes> handles_;  // port 0: free
};

/// The commands, tells and operands as tables (galil_commands.cpp).
std::string run_command(Galil& galil, std::string_view text);
double operand(Galil& galil, std::string_view name);

/// The QR record with all axes, without the prompt (galil_record.cpp).
std::string data_record(Galil& galil);

/// What the controller tells of an axis now, rounded as it tells it.
struct Tells {
  double position = 0, commanded = 0, error = 0, velocity = 0, torque_v = 0;
  std::uint8_t status = 0;  // TS
};
Tells tells(Galil& galil, int axis);

/// Conversations with `galil`, for a Server of 8 connections.
Server::Make galil_conversations(Galil& galil, Faults& faults);

}  // namespace trammel::emulate
