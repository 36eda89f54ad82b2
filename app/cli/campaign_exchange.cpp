#include "app/cli/campaign_exchange.hpp"

#include <fmt/format.h>

#include "app/exchange/stored_campaign.hpp"
#include "store/open.hpp"

namespace trammel::cli {

ExitCode run_campaign_import(const CampaignImportOptions& options, Context& context) {
  CampaignFile file = read_campaign(options.folder);
  if (!options.name.empty()) file.campaign.name = options.name;
  store::Connection connection = store::open(context.db(), store::Access::create);
  const store::ImportResult result = store_campaign(connection, file);
  const std::string& name = file.campaign.name;
  if (context.json) {
    context.print("campaign-import", {{"campaign", name},
                                      {"n_readings", file.campaign.readings.size()},
                                      {"already_stored", result.already_stored}});
  } else {
    context.print(fmt::format("{} campaign {}: {} readings",
                              result.already_stored ? "already stored:" : "imported",
                              printable(name), file.campaign.readings.size()));
  }
  context.next("trammel calibrate lsq " + shell_word(name));
  return ExitCode::ok;
}

ExitCode run_campaign_export(const CampaignExportOptions& options, Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, options.campaign);
  const CampaignFile file = stored_campaign(connection, campaign);
  write_campaign(file, options.folder);
  if (context.json) {
    context.print("campaign-export", {{"campaign", campaign.name},
                                      {"folder", options.folder},
                                      {"n_readings", file.campaign.readings.size()}});
  } else {
    context.print(fmt::format("exported campaign {}: {} readings to {}", printable(campaign.name),
                              file.campaign.readings.size(), printable(options.folder)));
  }
  return ExitCode::ok;
}

void setup_campaign_exchange(CLI::App& app, Context& context) {
  CLI::App& campaigns = noun(app, "campaign", "Campaigns: list, show, import, export");
  auto in = std::make_shared<CampaignImportOptions>();
  CLI::App* import = campaigns.add_subcommand("import", "Store a campaign/1 of another tool");
  import->add_option("FOLDER", in->folder, "Folder with campaign.json, or that file")->required();
  import->add_option("--name", in->name, "Name it is stored under (default: as the file says)");
  on_run(*import, context, in, run_campaign_import);

  auto out = std::make_shared<CampaignExportOptions>();
  CLI::App* exporting = campaigns.add_subcommand("export", "Write a campaign as campaign/1");
  exporting->add_option("CAMPAIGN", out->campaign, "Name or uuid")->required();
  exporting->add_option("FOLDER", out->folder, "Where campaign.json and readings.csv go")
      ->required();
  on_run(*exporting, context, out, run_campaign_export);
}

}  // namespace trammel::cli
