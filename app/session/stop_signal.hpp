#pragma once

#include <string>

namespace trammel::session {

/// From now on Ctrl-C (SIGINT), SIGTERM and SIGHUP are counted and no longer end the program, and a
/// stream that nobody reads any more (SIGPIPE) is an error of the stream. A SIGHUP that was ignored
/// (nohup) stays so.
void count_stop_signals();

/// 0: go on; 1: finish the point, then stop; 2 and more: stop now. Ctrl-C counts one; SIGTERM, and
/// SIGHUP, which comes when nobody watches any longer, two.
int stop_signals();

/// Of the last signal: "SIGHUP"; "the operator" for Ctrl-C and for what came otherwise.
std::string stop_signal_words();

}  // namespace trammel::session
