#pragma once
// The one robot that an emulated stage moves and an emulated tracker looks at.

#include <array>
#include <functional>
#include <mutex>
#include <optional>
#include <span>

#include "app/emulate/motion.hpp"
#include "core/simulate/virtual_robot.hpp"

namespace trammel::emulate {

/// Seconds that have passed in the emulated world: never backwards.
using NowS = std::function<double()>;

/// `speedup` seconds there for each one of the wall.
NowS wall_clock(double speedup);

/// How a motor is geared to its rail, as it truly is. Counts are those from the home switch.
///   l = home_mm + sign * counts * lead_mm * (1 + lead_error) / (counts_per_rev * gear)
struct RailSetup {
  double lead_mm = 10;
  double counts_per_rev = 8192;
  double gear = 1;                     // motor turns a screw turn
  int sign = 1;                        // +1: counts grow with l
  std::optional<double> home_mm = {};  // l at the home switch; absent: of the robot's home pose
  double lead_error = 0;               // the screw as made, beyond what the robot file hides
  double start_mm = 0;                 // where it stands at power-up, from the home switch
  double switch_margin_mm = 2;         // limit switches lie so far outside the mechanism's stroke
};

/// What the tracker's view depends on.
struct Standing {
  Displacements l_mm = Displacements::Zero();     // by the encoders, whole counts
  Displacements from_mm = Displacements::Zero();  // where each rail's last move began
  int epoch = 1;                                  // homings so far, at least 1
  double time_s = 0;                              // of work: moves and their settling
  bool moving = false;
  bool operator==(const Standing&) const = default;
};

/// Safe to use from several threads. The time that drift and warming see is the time of work, not
/// of the clock: the same moves give the same bits however long somebody waited between them.
class EmulatedRobot {
 public:
  using Rails = std::array<RailSetup, kChains>;

  /// Throws InputError for a rail that is no rail (lead, counts or gear not positive, sign not 1 or
  /// -1) or that would stand outside its switches at power-up.
  EmulatedRobot(simulate::VirtualRobot robot, const Rails& rails, NowS now);

  [[nodiscard]] const simulate::VirtualRobot& robot() const { return robot_; }
  [[nodiscard]] double now_s() const { return now_(); }
  [[nodiscard]] Standing standing() const;

  // The stage's side: motors in counts from the home switch.

  /// Where a limit switch acts: from `reverse` down, from `forward` up.
  struct Switches {
    double reverse = 0, forward = 0;
  };
  [[nodiscard]] Switches switches(int rail) const;
  [[nodiscard]] Motion at_power_up(int rail) const;

  struct Start {
    int rail = 0;
    Motion motion;
    bool homes = false;  // ends on the home switch, no lash taken up on either side
  };
  /// Moves that begin together. They take the time of the longest, and the robot's settling time.
  void begin(std::span<const Start> starts);
  /// What a rail does from now on, without a new beginning: stopped, aborted, without power.
  void change(int rail, const Motion& motion);

 private:
  struct Rail {
    RailSetup setup;
    double mm_per_count = 0;
    double home_mm = 0;
    Motion motion = Motion::at_rest(0);
    double began_mm = 0;  // where the present or last move began
    double from_mm = 0;   // where the one before it began, should this one go nowhere
    bool homes = false;
  };
  [[nodiscard]] static double place_mm(const Rail& rail, double now_s);
  [[nodiscard]] static double came_from_mm(const Rail& rail, double now_s);

  simulate::VirtualRobot robot_;
  NowS now_;
  mutable std::mutex mutex_;
  std::array<Rail, kChains> rails_;
  double work_s_ = 0;
  std::array<int, kChains> homings_ = {};
};

}  // namespace trammel::emulate
