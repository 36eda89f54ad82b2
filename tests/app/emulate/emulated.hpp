#pragma once
// Emulators over one virtual robot, and a clock that a test turns.

#include <optional>

#include "app/emulate/galil.hpp"
#include "app/emulate/tracker.hpp"
#include "core/units.hpp"

namespace trammel::tests {

/// The paper's robot with errors a tracker can see.
inline simulate::Truth emulated_truth() {
  simulate::Truth truth;
  truth.nominal = machine_of(paper_mechanism());
  truth.actual = truth.nominal.chains;
  truth.zeroed = true;
  truth.drive.lead_scale = {0.003, 0.002, 0.004};
  truth.drive.backlash_mm = {0.08, 0.07, 0.09};
  truth.drive.thermal_growth_per_k = {1.2e-5, 1.2e-5, 1.2e-5};
  truth.temperature = {20, 3, 2400};
  truth.tracker.sigma_xy_mm = 0.01;
  truth.tracker.sigma_phi_rad = rad_from_deg(0.055);
  truth.motion = {20, 5, 10};
  truth.seed = 7;
  return truth;
}

/// The controller alone, without a socket, its time in `now_s`.
struct Controller {
  double now_s = 0;
  emulate::Faults faults;
  emulate::EmulatedRobot robot;
  emulate::Galil galil{robot, faults};

  explicit Controller(const emulate::EmulatedRobot::Rails& rails = {},
                      const simulate::Truth& truth = emulated_truth())
      : robot(simulate::VirtualRobot(truth), rails, [this] { return now_s; }) {}

  std::string operator()(std::string_view line) { return galil.line(line); }
  double number(std::string_view line) { return std::stod(galil.line(line)); }
  /// Code of the error that the line leaves, 0 for none.
  int code_after(std::string_view line) {
    galil.error = 0;
    galil.line(line);
    return galil.error;
  }
};

/// Stage and tracker over one robot, each a server on loopback; an hour there takes a moment here.
struct EmulatedLaboratory {
  static constexpr double kSpeedup = 20000;
  emulate::Faults stage_faults, tracker_faults;
  emulate::EmulatedRobot robot;
  emulate::Galil galil;
  emulate::EmulatedTracker tracker;
  emulate::Server stage_server, tracker_server;

  explicit EmulatedLaboratory(const simulate::Truth& truth = emulated_truth(),
                              const emulate::EmulatedRobot::Rails& rails = {})
      : robot(simulate::VirtualRobot(truth), rails, emulate::wall_clock(kSpeedup)),
        galil(robot, stage_faults),
        tracker(
            robot.robot(), emulate::default_tracker(), [this] { return robot.standing(); },
            tracker_faults, kSpeedup),
        stage_server({}, emulate::galil_conversations(galil, stage_faults)),
        tracker_server({}, emulate::tracker_conversations(tracker, tracker_faults)) {}
};

}  // namespace trammel::tests
