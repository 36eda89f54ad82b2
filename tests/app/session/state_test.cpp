#include "app/session/state.hpp"

#include <set>
#include <utility>
#include <vector>

#include "tests/support/catch.hpp"

namespace trammel::session {

namespace {

std::set<State> reachable(State from) {
  std::set<State> seen = {from};
  std::vector<State> left = {from};
  while (!left.empty()) {
    const State at = left.back();
    left.pop_back();
    for (const Transition& way : transitions()) {
      if (way.from == at && seen.insert(way.to).second) left.push_back(way.to);
    }
  }
  return seen;
}

}  // namespace

TEST_CASE("every state is reached from planned, and no way is given twice", "[session]") {
  CHECK(reachable(State::planned).size() == 11);
  std::set<std::pair<State, Event>> ways;
  for (const Transition& way : transitions()) CHECK(ways.insert({way.from, way.event}).second);
}

TEST_CASE("what has ended does not go on by itself", "[session]") {
  for (const State end : {State::stopped, State::faulted, State::done}) {
    CHECK(reachable(end) == std::set<State>{end});
  }
}

TEST_CASE("done is reached by a count alone, stored by a commit alone", "[session]") {
  for (const Transition& way : transitions()) {
    CHECK((way.to == State::done) == (way.event == Event::counted));
    if (way.to == State::stored) CHECK(way.event == Event::committed);
    if (way.to == State::moving) CHECK(way.event == Event::move_begun);
  }
  CHECK_FALSE(next(State::planned, Event::move_begun).has_value());
  CHECK_FALSE(next(State::checked, Event::move_begun).has_value());
  CHECK_FALSE(next(State::moving, Event::committed).has_value());
}

}  // namespace trammel::session
