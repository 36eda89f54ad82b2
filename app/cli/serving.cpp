#include "app/cli/serving.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/error.hpp"

namespace trammel::cli {

sigset_t hold_signals() {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  return ends;
}

void serve_until_told(const std::string& text, const Json& object, const std::string& note,
                      const sigset_t& ends, const Context& context) {
  context.print(context.json ? object.dump() : text);
  if (std::fflush(stdout) != 0) {
    throw Error(ExitCode::error, {.what = "could not write to stdout"});
  }
  context.say(note);
  int signal = 0;
  sigwait(&ends, &signal);
}

}  // namespace trammel::cli
