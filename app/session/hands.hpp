#pragma once
// Everything a runner does with devices goes through here: each move is checked when it is sent,
// the beam is watched on the way, no call waits longer than its deadline, and no number that is not
// one gets in or out.

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/device/device.hpp"
#include "app/session/policy.hpp"
#include "app/session/watchdog.hpp"
#include "core/error.hpp"
#include "core/plan/check.hpp"

namespace trammel::session {

/// Why something did not succeed.
struct [[nodiscard]] Failure {
  enum class Cause {
    none,
    device,     // as `status` says; may be tried again where its rule allows
    hung,       // a call did not return: never again
    unsafe,     // what was to be sent, or where the rails stand, is outside what was checked
    storage,    // the database did not take it
    stepped,    // the deviations have made a step: is the set-up where it was?
    cancelled,  // the operator wants it to stop at once
    elsewhere,  // the platform was measured where it was not sent
    gross,      // the same, explained by a gross mistake (core/measure/gross.hpp)
  };
  Cause cause = Cause::none;
  device::Status status = device::Status::ok;
  std::string detail = {};

  [[nodiscard]] bool any() const { return cause != Cause::none; }
  /// "beam broken: stopped on the way"
  [[nodiscard]] std::string words() const;
  [[nodiscard]] ExitCode exit_code() const;
};
Failure unsafe(std::string detail);

/// From the wish to stop at once to the stage's stop, at most, while the database and the
/// controller answer.
inline constexpr double kStopDelayS = 0.3;

/// Where rails stand and where their last moves began.
struct Standing {
  Displacements l_mm = Displacements::Zero();
  Displacements from_mm = Displacements::Zero();
};

/// Proof: faults_test.cpp, watchdog_test.cpp, safety_test.cpp.
class Hands {
 public:
  /// `meanwhile` is asked every 20 ms while a call is waited for, whatever the call waits for;
  /// true: the stage is stopped at once, beside the call (from the wish to the stop: kStopDelayS at
  /// most).
  Hands(std::shared_ptr<device::Devices> devices, const CheckOptions& check,
        const Deadlines& deadlines, std::function<bool()> meanwhile);

  /// Where a stage stands that has just been homed.
  [[nodiscard]] const Standing& home_place() const { return home_; }
  [[nodiscard]] const Standing& place() const { return place_; }
  /// False after a move that was cut off: it is not known how the rails came to where they are.
  [[nodiscard]] bool on_course() const { return on_course_; }

  /// Where the stage said it stands after the last move.
  [[nodiscard]] const Displacements& encoder_mm() const { return encoder_mm_; }

  Failure home();
  /// Refuses, before anything is sent: not finite, out of the stroke, near a singular pose, links
  /// too close, too fast, at the end or on the way.
  Failure move(const Displacements& to_mm);
  /// First of all when something is wrong. A stage that does not answer is said in the failure.
  Failure stop();
  Failure beam();
  Failure temperature(const device::Occasion& occasion, double& temp_degc);
  Failure measure(const device::Occasion& occasion, device::PoseReport& seen);
  /// How far the base nests have moved since the tracker's frame was registered.
  Failure base(const device::Occasion& occasion, BaseDrift& drift);

 private:
  template <class Report>
  Failure call(const char* what, double deadline_s, Report& report,
               std::function<Report(device::Devices&)> ask);
  void stand_at(const Displacements& l_mm);
  void stop_beside();

  std::shared_ptr<device::Devices> devices_;
  CheckOptions check_;
  Deadlines deadlines_;
  std::function<bool()> meanwhile_;
  std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);
  Watchdog calls_;
  Watchdog stops_;  // a stage must be stoppable while another call hangs
  Standing home_;
  Standing place_;
  Displacements encoder_mm_ = Displacements::Zero();
  std::optional<Pose> measured_at_;  // where it stood at the last measurement that succeeded
  std::chrono::steady_clock::time_point stopped_beside_ = {};
  Pose pose_;  // near it: where the search for the next begins
  bool on_course_ = false;
  bool hung_ = false;
};

}  // namespace trammel::session
