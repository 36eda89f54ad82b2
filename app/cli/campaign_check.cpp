#include "app/cli/campaign_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/cli/next_step.hpp"
#include "app/files/campaign_file.hpp"
#include "app/files/stored_campaign.hpp"
#include "app/job/screening.hpp"
#include "app/terminal/counted.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

struct Looked {
  Campaign campaign;
  std::vector<std::pair<int, int>> held;
  bool stored = false;
};

Looked look_at_campaign(const std::string& what, const Context& context) {
  if (std::filesystem::exists(what)) {
    const CampaignFile file = read_campaign(what);
    return {baseline_of(file), held_epochs_of(file), false};
  }
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const CampaignFile file = stored_campaign(db, store::require_campaign(db, what));
  return {baseline_of(file), held_epochs_of(file), true};
}

ExitCode answer(const std::vector<Suspicion>& found) {
  const auto any = [&](Gravity gravity) {
    return std::ranges::any_of(
        found, [gravity](const Suspicion& s) { return rule_of(s.kind).gravity == gravity; });
  };
  return any(Gravity::gross)   ? ExitCode::invalid_data
         : any(Gravity::doubt) ? ExitCode::not_acceptable
                               : ExitCode::ok;
}

}  // namespace

ExitCode run_campaign_check(const CampaignCheckOptions& options, Context& context) {
  const auto [campaign, held, stored] = look_at_campaign(options.campaign, context);
  const std::vector<Suspicion> found = screened(campaign, held);
  const ExitCode code = answer(found);
  const char* verdict = code == ExitCode::ok               ? "sound"
                        : code == ExitCode::not_acceptable ? "doubtful"
                                                           : "gross";
  if (context.json) {
    context.print("campaign-check", {{"campaign", campaign.name},
                                     {"stored", stored},
                                     {"n_readings", campaign.readings.size()},
                                     {"verdict", verdict},
                                     {"findings", job::findings_json(found)}});
  } else {
    context.print(
        fmt::format("{}: {}, {}\n", bold(printable(campaign.name)),
                    terminal::counted(campaign.readings.size(), "reading"),
                    code == ExitCode::ok ? "nothing gross and nothing doubtful" : verdict) +
        job::findings_text(found));
  }
  if (code != ExitCode::invalid_data) {
    context.next((stored ? first_calibration(campaign.machine) : "trammel campaign import ") +
                 shell_word(options.campaign));
  }
  return code;
}

void setup_campaign_check(Command campaigns, Context& context) {
  auto options = std::make_shared<CampaignCheckOptions>();
  Command check = campaigns.command(
      "check", "The screen: frames, units, columns, clocks and bad readings, by seq");
  check
      .option("CAMPAIGN", options->campaign,
              "Name or uuid; or a folder with campaign.json, or that file")
      .required();
  on_run(check, context, options, run_campaign_check);
}

}  // namespace trammel::cli
