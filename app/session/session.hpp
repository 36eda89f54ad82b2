#pragma once
// A session from plan to count: run, resume after any death, stop.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "app/device/open.hpp"
#include "app/session/policy.hpp"
#include "app/session/state.hpp"
#include "core/calibrate/correction.hpp"
#include "core/plan/check.hpp"
#include "core/plan/plan.hpp"
#include "store/session.hpp"

namespace trammel::session {

/// What a session is begun with. All of it is stored; a resume needs no more than the name.
struct Request {
  std::string campaign;  // made when it is not there
  std::string session;   // its name in the campaign
  Plan plan;
  std::string stage;  // "sim:FILE"
  std::string tracker = "sim";
  std::optional<store::Id> compensation_job = {};  // none: baseline
  CheckOptions check = {};
  Policy policy = {};
  std::string plan_check = {};  // file of `plan check --record`, asked for by a real stage
  double pause_s = 600;         // simulated time since the end of the session before
  bool new_set_up = false;      // homed and framed anew: an epoch of its own
  std::map<std::string, std::string> facts = {};  // of a campaign that is made, beside its devices
  std::vector<std::string> confirmed = {};        // what a person did before it begins, for its log
};

/// What is checked is the speed the stage is set to; its own cap holds where it is lower.
CheckOptions check_for(CheckOptions check, const device::Motion& motion);

void really_sleep(double seconds);

/// The world around a session.
struct Surroundings {
  /// The correction that a job has stored. Needed for compensated sessions.
  std::function<Correction(store::Connection&, store::Id)> correction_of = {};
  std::function<int()> stop_signals = [] { return 0; };
  std::function<std::string()> stopped_by = [] { return "the operator"; };  // who asked
  bool quiet = true;
  bool terminal = false;
  Deadlines deadlines = {};
  std::function<device::Devices(const std::string& stage, const std::string& tracker)> open =
      &device::open_devices;
  std::function<void(double seconds)> sleep = &really_sleep;
  std::function<void(int n_stored)> stored = {};  // called when a point is stored
};

struct Outcome {
  State state = State::planned;  // done, stopped, faulted
  store::Id session_id = 0;      // 0: refused before it was stored
  int n_points = 0;
  int n_before = 0;  // ok points of earlier runs
  int n_stored = 0;  // of this run
  std::string detail = {};
  ExitCode fault = ExitCode::device;       // faulted only: what kind
  std::vector<Violation> violations = {};  // not empty: refused before the first move
  std::vector<std::string> missing = {};   // the same: what a real stage asks for and has not got
  double estimated_s = 0;                  // of the points that are left, before the start
  std::string plan_sha256 = {};
  std::optional<double> watch_host_s = {};  // device::watch_text; nothing: no controller

  [[nodiscard]] bool refused() const { return !violations.empty() || !missing.empty(); }
  /// 0 done, 6 refused or unsafe, 7 a device, 8 the database, 130 stopped.
  [[nodiscard]] ExitCode exit_code() const;
};

/// The whole plan as it would be commanded, checked; nothing is stored and nothing moves. A
/// campaign that `connection` has is refused as by run (InputError).
Outcome dry_run(const Request& request, const Correction& correction,
                const Surroundings& surroundings = {}, store::Connection* connection = nullptr);

/// Checks the whole plan, stores the session, then measures point by point: the intent is committed
/// before the move, readings and attempt = ok in one transaction. Throws InputError when the
/// campaign has a session of this name, or another mechanism; Error when the campaign is being
/// measured by another process.
/// Proof: session_test.cpp (killed at random times, the readings are those of an undisturbed run).
Outcome run(store::Connection& connection, const Request& request,
            const Surroundings& surroundings);

/// Goes on with the points that have no ok attempt: homes, measures up to three stored points again
/// (in a session of their own, "NAME, reference N"), refuses when they moved by more than the
/// tolerance, opens an epoch and measures what is left. A session that is done is left alone.
Outcome resume(store::Connection& connection, const std::string& campaign,
               const std::string& session, const Surroundings& surroundings);

/// What resume would go on with: n_before points are stored, the rest is checked. Nothing is stored
/// and nothing moves. Throws as resume.
Outcome dry_resume(store::Connection& connection, const std::string& campaign,
                   const std::string& session, const Surroundings& surroundings = {});

/// run, or resume where the session is there already: done once, whatever happens in between.
/// Throws InputError when the stored session is not what is asked for (agreement.hpp).
Outcome run_or_resume(store::Connection& connection, const Request& request,
                      const Surroundings& surroundings);

/// How far a re-measured point may be from where it was.
struct ReferenceTolerance {
  double xy_mm = 0.1;
  double phi_rad = 0.0035;  // 0.2 deg; each is at least 6 sigma of the difference of two readings
};

}  // namespace trammel::session
