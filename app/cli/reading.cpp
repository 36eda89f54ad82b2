#include "app/cli/reading.hpp"

#include <fmt/format.h>

#include "store/campaign.hpp"
#include "store/open.hpp"

namespace trammel::cli {

ExitCode run_reading_exclude(const ReadingExcludeOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::write);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  store::exclude_reading(db, campaign.id, options.seq, options.reason);
  if (context.json) {
    context.print("reading-exclude",
                  {{"campaign", campaign.name}, {"seq", options.seq}, {"reason", options.reason}});
  } else {
    context.print(fmt::format("reading {} of {} is left out from now on; it stays stored",
                              options.seq, printable(campaign.name)));
  }
  return ExitCode::ok;
}

void setup_reading(CLI::App& app, Context& context) {
  CLI::App& readings = noun(app, "reading", "Readings: exclude");
  const auto options = std::make_shared<ReadingExcludeOptions>();
  CLI::App* exclude =
      readings.add_subcommand("exclude", "Leave a reading out of later jobs, with a reason");
  exclude->add_option("CAMPAIGN", options->campaign, "Name or uuid")->required();
  exclude->add_option("--seq", options->seq, "Which reading")->required();
  exclude->add_option("--reason", options->reason, "Why")->required();
  on_run(*exclude, context, options, run_reading_exclude);
}

}  // namespace trammel::cli
