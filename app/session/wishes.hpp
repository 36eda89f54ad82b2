#pragma once
// What is asked of a runner while it runs: by Ctrl-C on its terminal, or by another process through
// the database, where the question stays on record.

#include <functional>

#include "store/session.hpp"

namespace trammel::session {

enum class Wish { none, go_on, pause, stop, stop_now };  // the later, the stronger

/// Adds the question to the session's log; the runner sees it within a poll. One that came before
/// the runner began, or after it ended, asks nothing of the next.
void ask(store::Connection& connection, store::Id session, Wish wish);

/// The runner's side.
class Wishes {
 public:
  /// `signals`: 0, 1 finish the point and stop, 2 stop now.
  Wishes(store::Connection& connection, store::Id session, std::function<int()> signals);

  /// What is wanted now. A stop stays; a pause is over when it was asked to go on, or `taken`.
  Wish now();
  /// The pause has begun, or ended.
  void taken() { asked_ = asked_ >= Wish::stop ? asked_ : Wish::none; }

 private:
  store::Connection& connection_;
  store::Id session_;
  store::Id seen_ = 0;
  std::function<int()> signals_;
  Wish asked_ = Wish::none;
};

}  // namespace trammel::session
