#pragma once
// Commands that serve until they are told to end: emulate, serve.

#include <signal.h>

#include "app/cli/context.hpp"

namespace trammel::cli {

/// SIGINT and SIGTERM, blocked from here on. Asked for before a server makes its threads, so that
/// they are for us alone.
sigset_t hold_signals();

/// Prints where it listens, at once: `text`, or with --json `object` on one line (who started us
/// reads as far as its end). Says `note`, and returns when one of `ends` comes.
void serve_until_told(const std::string& text, const Json& object, const std::string& note,
                      const sigset_t& ends, const Context& context);

}  // namespace trammel::cli
