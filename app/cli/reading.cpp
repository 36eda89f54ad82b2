#include "app/cli/reading.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/next_step.hpp"
#include "store/campaign.hpp"
#include "store/machine.hpp"
#include "store/open.hpp"
#include "store/transaction.hpp"

namespace trammel::cli {

ExitCode run_reading_exclude(const ReadingExcludeOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::write);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  store::Transaction transaction(db);
  store::exclude_reading(db, campaign.id, options.seq, options.reason);
  if (!options.dry_run) transaction.commit();  // else all of it is rolled back
  if (context.json) {
    context.print("reading-exclude", {{"campaign", campaign.name},
                                      {"seq", options.seq},
                                      {"reason", options.reason},
                                      {"dry_run", options.dry_run}});
  } else {
    context.print(fmt::format(
        fmt::runtime(options.dry_run ? "reading {} of {} would be left out; nothing was stored"
                                     : "reading {} of {} is left out from now on; it stays stored"),
        options.seq, printable(campaign.name)));
  }
  if (!options.dry_run) {
    context.next(first_calibration(store::load_machine(db, campaign.id)) +
                 shell_word(campaign.name));
  }
  return ExitCode::ok;
}

void setup_reading(Command app, Context& context) {
  Command readings = noun(app, "reading", "Readings: exclude");
  const auto options = std::make_shared<ReadingExcludeOptions>();
  Command exclude = readings.command("exclude", "Leave a reading out of later jobs, with a reason");
  exclude.option("CAMPAIGN", options->campaign, "Name or uuid").required();
  exclude.option("--seq", options->seq, "Which reading").required();
  exclude.option("--reason", options->reason, "Why").required();
  exclude.flag("--dry-run", options->dry_run, "Check and print; nothing is stored");
  on_run(exclude, context, options, run_reading_exclude);
}

}  // namespace trammel::cli
