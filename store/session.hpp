#pragma once
// A session: an immutable plan walked through under one compensation; its epochs and attempts.
//
// The runner's order of calls: create_session; open_epoch; then for each of open_points:
// begin_attempt (committed before the move), the move, finish_attempt or fail_attempt. After a
// death: interrupt_open_attempts, open_epoch, and on with open_points.

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "store/reading.hpp"

namespace trammel::store {

struct Point {
  int seq = 0;  // in the plan, from 1
  ReadingSet set = ReadingSet::identify;
  Pose target;
  std::array<int, 3> approach = {};  // +1, -1, or 0: as it comes
  int repeat = 1;
  bool reference = false;
  std::string role = {};
  Displacements planned_mm = Displacements::Zero();  // as checked before the first move
};

struct NewSession {
  Id campaign_id = 0;
  std::string name;
  std::optional<Id> compensation_job = {};  // none: baseline, unless there is a name
  std::string compensation_name = {};       // with a job: its stage, where it is left out
  std::string plan_name = {};
  std::vector<Point> points = {};
  int n_imported = 0;  // readings that come with it, without a plan
  int n_asked = 0;     // points that the walk was to have, of an imported one; 0: not known
  std::string stage = {};
  std::string tracker = {};
  std::string settings_json = "{}";  // whatever else a resume needs
};

/// Stores the session with its plan, in one transaction.
/// @throws InputError  the campaign has a session of this name
Id create_session(Connection& connection, const NewSession& session);

struct SessionRow {
  Id id = 0;
  Id campaign_id = 0;
  std::string name;
  std::optional<Id> compensation_job;
  std::string compensation_name;  // empty: baseline
  std::string plan_name;
  std::string stage;
  std::string tracker;
  std::string settings_json;
  std::string created_utc;
  int n_points = 0;
  int n_asked = 0;  // of an imported walk: points it was to have; 0: not known
  int n_ok = 0;     // points with an ok attempt
  int n_readings = 0;
  std::string last_event;  // started, paused, resumed, stopped, faulted, done; "": none of them

  [[nodiscard]] bool compensated() const { return !compensation_name.empty(); }
};
std::vector<SessionRow> list_sessions(Connection& connection, Id campaign_id);
/// The same without what has to be counted.
struct SessionName {
  Id id = 0;
  std::string name;
  bool compensated = false;
  bool references = false;  // visits of reference points in between: a check, no measurement
};
std::vector<SessionName> session_names(Connection& connection, Id campaign_id);
std::optional<SessionRow> find_session(Connection& connection, Id campaign_id,
                                       std::string_view name);
SessionRow get_session(Connection& connection, Id session_id);

/// What an imported session keeps of its walk, in its settings: {"roles": {"41": "circle 1"}}.
struct ImportedWalk {
  std::map<int, std::string> roles;  // of readings by seq
};
ImportedWalk imported_walk(const SessionRow& session);
/// `settings_json`, an object, with these roles.
std::string with_roles(const std::string& settings_json, const std::map<int, std::string>& roles);

std::vector<Point> points(Connection& connection, Id session_id);
/// Points without an ok attempt, in the order of the plan: what a resume has still to do.
std::vector<Point> open_points(Connection& connection, Id session_id);

struct Epoch {
  Id id = 0;
  int number = 0;     // Conditions::epoch
  bool held = false;  // reference points were found where they had been
};
enum class SetUp { fresh, as_before };
/// One homing and frame set-up. `fresh` takes the campaign's next number; `as_before` goes on under
/// the campaign's last set-up (a new session without homing in between), and is not for a resume.
Epoch open_epoch(Connection& connection, Id session_id, SetUp set_up, std::string_view reason);
Id add_epoch(Connection& connection, Id session_id, int number, std::string_view reason);
std::vector<Epoch> epochs(Connection& connection, Id session_id);

/// Plan of the sessions that only visit reference points.
inline constexpr const char* kReferencePlan = "reference points";
/// Why an epoch was opened in which the reference points were found where they had been.
inline constexpr const char* kReferencesHold = "resume, reference points hold";
/// Numbers of epochs between which the set-up held: such an epoch with each that its session had
/// before.
std::vector<std::pair<int, int>> held_epochs(Connection& connection, Id campaign_id);

/// The intent, committed before the move.
/// @throws StoreError  the point has an open or an ok attempt already
Id begin_attempt(Connection& connection, Id session_id, int point_seq, Id epoch_id);

/// Readings and attempt = ok in one transaction; returns the readings' seq. Each reading gets the
/// attempt's epoch. Stored when this has returned. `walk`, how the runner came there, is an event
/// of the same transaction.
/// @throws InputError  no reading, or one with a number out of bounds; nothing is stored
std::vector<int> finish_attempt(Connection& connection, Id attempt_id,
                                const std::vector<NewReading>& readings,
                                std::string_view walk = {});

/// A failed attempt is a stored row.
void fail_attempt(Connection& connection, Id attempt_id, std::string_view detail,
                  std::string_view walk = {});

/// Closes the attempts a dead runner left open, as interrupted. Returns how many.
int interrupt_open_attempts(Connection& connection, Id session_id, std::string_view detail);

struct Attempt {
  Id id = 0;
  int point_seq = 0;
  int number = 0;
  int epoch = 0;
  std::string status;  // open, ok, failed, interrupted
  int n_readings = 0;
  std::string detail;
  std::string opened_utc;
  std::string closed_utc;  // "" while it is open
};
std::vector<Attempt> attempts(Connection& connection, Id session_id);

/// The session's log: started, paused, resumed, stopped, faulted, done; what a runner passed
/// through and what is asked of it (app/session/README.md).
Id add_event(Connection& connection, Id session_id, std::string_view kind,
             std::string_view detail = "");
struct Event {
  Id id = 0;
  std::string kind;
  std::string detail;
  std::string at_utc;
};
/// From here on utc_now() is not before anything that the session has stored: its times never go
/// back, whatever was done to the computer's date since.
void hold_clock(Connection& connection, Id session_id);

/// In order; those after event `after`.
std::vector<Event> events(Connection& connection, Id session_id, Id after = 0);

}  // namespace trammel::store
