#pragma once
// The stage behind a Galil DMC-41x3: servo axes that move the drives of a machine, one to three.
//
// Software is no emergency stop: what stops the machine when this program, the network or the
// controller fails is a switch that cuts the drives' power.

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "app/device/device.hpp"
#include "app/device/galil_settings.hpp"
#include "app/device/galil_watch.hpp"
#include "app/device/galil_wire.hpp"

namespace trammel::device {

/// Connects at the first use. A lost answer means that the outcome is unknown: the stage is asked
/// on a new connection what is, stopped when it moves, and the report says what was lost and where
/// the rails stand; it is `timeout`, and `fault` when nothing answers or the controller has
/// forgotten its set-up (then it must be homed again). Every way out of a move that failed sends
/// ST (AB where that is refused) and waits until the rails rest; servos are switched off after a
/// fault or a following error, and when the stage is destroyed. With `watch_host_s` the controller
/// watches this program from homing on. One thread at a time; stop() from
/// another thread stops over a connection of its own.
/// Proof: galil_test.cpp.
class GalilStage : public Stage {
 public:
  explicit GalilStage(GalilSettings settings);
  ~GalilStage() override;

  [[nodiscard]] std::string describe() const override;
  [[nodiscard]] bool homed() const override { return homed_; }
  /// Servos on, all rails to their home switches (HM), count 0 there, soft limits set in the
  /// controller, then to the machine's home pose.
  StageReport home() override;
  StageReport move(const Displacements& to_mm, const Watch& watch) override;
  StageReport stop() override;

 private:
  StageReport guarded(const std::function<StageReport()>& body);
  void connect();
  StageReport halt(StageReport why, bool lost);
  StageReport stop_beside() const;
  void motors_off();

  void set_up_axes();
  void watch_host();
  [[nodiscard]] bool is_watched();
  StageReport find_switches();
  void set_soft_limits();
  [[nodiscard]] bool remembers_set_up();

  StageReport travel(const Displacements& to_mm, const Watch& watch);
  void start(const GalilMove& move);
  void set(const char* name, std::size_t axis, std::int64_t value);
  StageReport follow(const std::string& moving, double time_s, int meant, const Watch& watch);
  StageReport settle(const Watch& watch);
  StageReport standing(const Displacements& to_mm);
  [[nodiscard]] std::string name(std::size_t axis) const;  // "rail 2", "y axis"
  [[nodiscard]] std::string place_text(const Displacements& l_mm) const;

  GalilSettings settings_;
  std::unique_ptr<GalilWire> wire_;
  std::unique_ptr<GalilHostWatch>
      watch_;        // where it is asked for: from homing until servos are off
  std::mutex busy_;  // one call at a time, but for stop()
  std::string identity_;
  std::atomic<bool> homed_ = false;
};

}  // namespace trammel::device
