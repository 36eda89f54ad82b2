#pragma once

namespace trammel::session {

/// From now on Ctrl-C (SIGINT, SIGTERM) is counted and no longer ends the program.
void count_stop_signals();

/// 0: go on; 1: finish the point, then stop; 2 and more: stop now.
int stop_signals();

}  // namespace trammel::session
