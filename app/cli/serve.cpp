#include "app/cli/serve.hpp"

#include "app/cli/serving.hpp"
#include "app/serve/server.hpp"

namespace trammel::cli {

namespace {

ExitCode run_serve(const serve::Options& options, Context& context) {
  serve::Options page = options;
  page.database = context.db();
  const sigset_t ends = hold_signals();
  const serve::Server server(page);
  serve_until_told(
      server.url(),
      {{"schema", "trammel/serve/1"}, {"campaign", page.campaign}, {"url", server.url()}},
      "read only, and for this machine alone; Ctrl-C ends it", ends, context);
  return ExitCode::ok;
}

}  // namespace

void setup_serve(Command app, Context& context) {
  auto options = std::make_shared<serve::Options>();
  Command command = app.command(
      "serve", "The report as a live page in a browser of this machine, while a session runs");
  command.option("CAMPAIGN", options->campaign, "Name or uuid").required();
  command.option("--session", options->session, "the one to watch (the latest)").type("SESSION");
  command.option("--port", options->port, "where it answers; 0 finds a free one")
      .range(0, 65535)
      .shown_default();
  on_run(command, context, options, run_serve);
}

}  // namespace trammel::cli
