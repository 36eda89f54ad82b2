#pragma once
// The states of a session and every way from one to another, as one table.

#include <optional>
#include <span>

namespace trammel::session {

enum class State {
  planned,
  checked,
  homed,
  moving,
  settling,
  measuring,
  stored,
  paused,
  stopped,
  faulted,
  done,
};

enum class Event {
  check_passed,
  check_failed,
  set_up,      // homed, epoch open, reference points where they were
  move_begun,  // the intent is committed
  in_position,
  settled,    // the reflector is locked
  committed,  // readings and attempt = ok are in the store
  try_again,  // a failure that may pass; the attempt is stored as failed
  pause_asked,
  resumed,          // asked to go on after a pause: a set-up follows
  conditions_bad,   // temperature out of its band, a reference point has drifted
  conditions_good,  // and well inside again
  stop_asked,
  failed,   // a failure that may not be tried again, or too often
  counted,  // every planned point has an ok attempt
};

struct Transition {
  State from;
  Event event;
  State to;
};
std::span<const Transition> transitions();

/// None: the table has no such way.
std::optional<State> next(State from, Event event);

/// "planned", … as status shows them.
const char* name_of(State state);
/// "check passed", …
const char* name_of(Event event);

}  // namespace trammel::session
