#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/protocol/protocol.hpp"
#include "app/session/session.hpp"
#include "store/connection.hpp"

namespace trammel::protocol {

struct StepOutcome {
  std::string name;
  std::string kind;                        // "measure", "calibrate", "diagnose"
  bool done_before = false;                // stored by an earlier run: nothing was repeated
  bool skipped = false;                    // there was nothing to measure
  std::string detail = {};                 // "80 points", "job 3"
  std::vector<Violation> violations = {};  // why nothing moved
  ExitCode code = ExitCode::ok;
};

struct Outcome {
  std::vector<StepOutcome> steps;  // up to the one that did not end well
  ExitCode code = ExitCode::ok;
};

/// Executes the steps in order into the campaign of the protocol's name. Whatever an earlier run
/// has stored is kept: a session goes on at its first missing point, a job of the same key is
/// reused. Suggested points are skipped where the diagnosis suggests none, and later steps
/// go on without them. A step that is stopped or faults ends the run with its exit code. `tell`
/// hears each step as it ends. Proof: killed at random times and run again, the final numbers are
/// those of an undisturbed run (demo_test.cpp).
Outcome run(store::Connection& connection, const Protocol& protocol,
            const session::Surroundings& surroundings,
            const std::function<void(const StepOutcome&)>& tell);

/// Opens the robot and checks the plan of every measure step that has one by now, without
/// correction: the steps that are not safe, none when all may start. Nothing is stored. Throws as
/// open_devices.
std::vector<StepOutcome> preflight(const Protocol& protocol);

/// What `run` would do, step by step: done_before tells what is stored, detail what is left.
/// Nothing is stored and nothing moves; `connection` may be null where there is no database yet.
std::vector<StepOutcome> dry_run(store::Connection* connection, const Protocol& protocol);

}  // namespace trammel::protocol
