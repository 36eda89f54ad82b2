#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "app/protocol/protocol.hpp"
#include "app/session/session.hpp"
#include "store/connection.hpp"

namespace trammel::protocol {

struct StepOutcome {
  std::string name;
  std::string kind;                        // "measure", "calibrate", …
  bool done_before = false;                // stored by an earlier run: nothing was repeated
  bool skipped = false;                    // there was nothing to measure, or to ask for
  std::string detail = {};                 // "80 points", "job 3"
  std::vector<Violation> violations = {};  // why nothing moved
  std::vector<std::string> missing = {};   // the same: what a real stage asks for and has not got
  double estimated_s = 0;                  // of what is left to measure, before it begins
  ExitCode code = ExitCode::ok;
};

struct Outcome {
  std::vector<StepOutcome> steps;  // up to the one that did not end well
  ExitCode code = ExitCode::ok;
};

/// Every measure step by its name, as a session is begun with: its devices opened for their
/// mechanism, its plan made (none yet where it is suggested). No real device is spoken to. Throws
/// as open_devices, read_plan and grid_plan.
using Requests = std::map<std::string, session::Request>;
Requests requests_of(const Protocol& protocol);

/// Checks the plan of every measure step that has one by now, without correction: an outcome each,
/// with its violations, what is missing and how long it takes. Nothing is stored. Proof:
/// tests/app/protocol/any_test.cpp.
std::vector<StepOutcome> preflight(const Protocol& protocol, const Requests& requests,
                                   store::Connection* connection);

/// Who sits beside a run.
struct Person {
  std::function<void(const StepOutcome&)> tell;  // hears each step as it ends
  /// Whether what the pause `name` asks for is done. No: the run ends there (exit 130).
  std::function<bool(const std::string& name, const std::string& ask)> confirms =
      [](const auto&, const auto&) { return false; };
};

/// Executes the steps in order into the campaign of the protocol's name. Whatever an earlier run
/// has stored is kept: a session goes on at its first missing point, a job of the same key is
/// reused. Suggested points are skipped where the diagnosis suggests none, and later steps
/// go on without them. A pause is over when the measure step after it has begun, whose log it
/// stands in. A step that is stopped or faults ends the run with its exit code. Proof: killed at
/// random times and run again, the final numbers are those of an undisturbed run (demo_test.cpp);
/// killed in every step, any_test.cpp.
Outcome run(store::Connection& connection, const Protocol& protocol, const Requests& requests,
            const session::Surroundings& surroundings, const Person& person);

/// What `run` would do, step by step: done_before tells what is stored, detail what is left, and
/// estimated_s how long that takes. Nothing is stored and nothing moves; `connection` may be null
/// where there is no database yet.
std::vector<StepOutcome> dry_run(store::Connection* connection, const Protocol& protocol,
                                 const Requests& requests);

}  // namespace trammel::protocol
