#include "app/session/wishes.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace trammel::session {

namespace {

struct Kind {
  Wish wish;
  const char* kind;
};
constexpr std::array<Kind, 4> kKinds = {{{Wish::go_on, "go on asked"},
                                         {Wish::pause, "pause asked"},
                                         {Wish::stop, "stop asked"},
                                         {Wish::stop_now, "stop now asked"}}};

}  // namespace

void ask(store::Connection& connection, store::Id session, Wish wish) {
  store::hold_clock(connection, session);
  for (const Kind& k : kKinds) {
    if (k.wish == wish) store::add_event(connection, session, k.kind);
  }
}

Wishes::Wishes(store::Connection& connection, store::Id session, std::function<int()> signals)
    : connection_(connection), session_(session), signals_(std::move(signals)) {
  const auto before = store::events(connection, session);
  if (!before.empty()) seen_ = before.back().id;
}

Wish Wishes::now() {
  const int signals = signals_();
  if (signals >= 2) return Wish::stop_now;  // whatever the database says, and when
  for (const store::Event& event : store::events(connection_, session_, seen_)) {
    seen_ = event.id;
    for (const Kind& k : kKinds) {
      if (event.kind == k.kind) asked_ = asked_ >= Wish::stop ? std::max(asked_, k.wish) : k.wish;
    }
  }
  return std::max(asked_, signals == 1 ? Wish::stop : Wish::none);
}

}  // namespace trammel::session
