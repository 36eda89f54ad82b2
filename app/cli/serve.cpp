#include "app/cli/serve.hpp"

#include <signal.h>

#include <cstdio>

#include "app/serve/server.hpp"

namespace trammel::cli {

namespace {

/// SIGINT and SIGTERM, blocked before the server makes its threads: they are for us alone.
sigset_t held_signals() {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  return ends;
}

ExitCode run_serve(const serve::Options& options, Context& context) {
  serve::Options page = options;
  page.database = context.db();
  const sigset_t ends = held_signals();
  const serve::Server server(page);
  if (context.json) {  // on one line: who started us reads as far as its end
    context.print(
        Json{{"schema", "trammel/serve/1"}, {"campaign", page.campaign}, {"url", server.url()}}
            .dump());
  } else {
    context.print(server.url());
  }
  if (std::fflush(stdout) != 0) {
    throw Error(ExitCode::error, {.what = "could not write to stdout"});
  }
  context.say("read only, and for this machine alone; Ctrl-C ends it");
  int signal = 0;
  sigwait(&ends, &signal);
  return ExitCode::ok;
}

}  // namespace

void setup_serve(CLI::App& app, Context& context) {
  auto options = std::make_shared<serve::Options>();
  CLI::App* command = app.add_subcommand(
      "serve", "The report as a live page in a browser of this machine, while a session runs");
  command->add_option("CAMPAIGN", options->campaign, "Name or uuid")->required();
  command->add_option("--session", options->session, "the one to watch (the latest)")
      ->type_name("SESSION");
  command->add_option("--port", options->port, "where it answers; 0 finds a free one")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  on_run(*command, context, options, run_serve);
}

}  // namespace trammel::cli
