#include "app/cli/assess.hpp"

#include <nlohmann/json.hpp>

#include "app/report/assess/assessment.hpp"
#include "store/open.hpp"

namespace trammel::cli {

ExitCode run_assess(const AssessOptions& options, Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const assess::Assessment found =
      assess::gather(connection, store::require_campaign(connection, options.campaign),
                     options.session, options.job);
  if (context.json) {
    context.print("assess", assess::to_json(found));
  } else {
    context.print(assess::to_text(found));
  }
  return ExitCode::ok;
}

void setup_assess(Command app, Context& context) {
  auto options = std::make_shared<AssessOptions>();
  Command command = app.command(
      "assess", "ISO 9283 and ISO 230-2 symbols, or why not; uncertainty of a correction");
  command.option("CAMPAIGN", options->campaign, "Name or uuid").required();
  command.option("--session", options->session, "This session alone").type("SESSION");
  command
      .option("--job", options->job,
              "Judge this job's correction: its number, or six digits of its key")
      .type("JOB");
  on_run(command, context, options, run_assess);
}

}  // namespace trammel::cli
