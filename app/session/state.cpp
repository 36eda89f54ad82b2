#include "app/session/state.hpp"

#include <array>

namespace trammel::session {

namespace {

using enum State;

constexpr std::array<Transition, 33> kTransitions = {{
    {planned, Event::check_passed, checked},
    {planned, Event::check_failed, stopped},
    {checked, Event::set_up, homed},
    {checked, Event::stop_asked, stopped},
    {checked, Event::failed, faulted},
    {homed, Event::move_begun, moving},
    {homed, Event::pause_asked, paused},
    {homed, Event::conditions_bad, paused},
    {homed, Event::stop_asked, stopped},
    {homed, Event::failed, faulted},
    {homed, Event::counted, done},
    {moving, Event::in_position, settling},
    {moving, Event::try_again, homed},
    {moving, Event::stop_asked, stopped},
    {moving, Event::failed, faulted},
    {settling, Event::settled, measuring},
    {settling, Event::try_again, homed},
    {settling, Event::stop_asked, stopped},
    {settling, Event::failed, faulted},
    {measuring, Event::committed, stored},
    {measuring, Event::try_again, homed},
    {measuring, Event::stop_asked, stopped},
    {measuring, Event::failed, faulted},
    {stored, Event::move_begun, moving},
    {stored, Event::pause_asked, paused},
    {stored, Event::conditions_bad, paused},
    {stored, Event::stop_asked, stopped},
    {stored, Event::failed, faulted},  // the count does not come out
    {stored, Event::counted, done},
    {paused, Event::resumed, checked},
    {paused, Event::conditions_good, homed},
    {paused, Event::stop_asked, stopped},
    {paused, Event::failed, faulted},
}};

}  // namespace

std::span<const Transition> transitions() { return kTransitions; }

std::optional<State> next(State from, Event event) {
  for (const Transition& way : kTransitions) {
    if (way.from == from && way.event == event) return way.to;
  }
  return std::nullopt;
}

const char* name_of(State state) {
  constexpr std::array<const char*, 11> kNames = {"planned",  "checked",   "homed",  "moving",
                                                  "settling", "measuring", "stored", "paused",
                                                  "stopped",  "faulted",   "done"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* name_of(Event event) {
  constexpr std::array<const char*, 15> kNames = {
      "check passed",   "check failed",    "set up",     "move begun",  "in position",
      "settled",        "committed",       "try again",  "pause asked", "resumed",
      "conditions bad", "conditions good", "stop asked", "failed",      "counted"};
  return kNames[static_cast<std::size_t>(event)];
}

}  // namespace trammel::session
