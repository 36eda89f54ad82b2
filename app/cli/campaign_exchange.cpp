#include "app/cli/campaign_exchange.hpp"

#include <fmt/format.h>

#include "app/exchange/stored_campaign.hpp"
#include "store/open.hpp"
#include "store/transaction.hpp"

namespace trammel::cli {

namespace {

store::ImportResult stored(const CampaignFile& file, const Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::create);
  return store_campaign(connection, file);
}

/// Every check of an import, and all of it rolled back.
store::ImportResult tried(const CampaignFile& file, const Context& context) {
  if (!std::filesystem::exists(context.db())) return {};
  store::Connection connection = store::open(context.db(), store::Access::write);
  const store::Transaction rolled_back(connection);
  return store_campaign(connection, file);
}

}  // namespace

ExitCode run_campaign_import(const CampaignImportOptions& options, Context& context) {
  CampaignFile file = read_campaign(options.folder);
  if (!options.name.empty()) file.campaign.name = options.name;
  const store::ImportResult result = options.dry_run ? tried(file, context) : stored(file, context);
  const std::string& name = file.campaign.name;
  if (context.json) {
    context.print("campaign-import", {{"campaign", name},
                                      {"n_readings", file.campaign.readings.size()},
                                      {"already_stored", result.already_stored},
                                      {"dry_run", options.dry_run}});
  } else {
    context.print(fmt::format("{} campaign {}: {} readings",
                              result.already_stored ? "already stored:"
                              : options.dry_run     ? "dry run, would import"
                                                    : "imported",
                              printable(name), file.campaign.readings.size()));
  }
  if (!options.dry_run) context.next("trammel calibrate lsq " + shell_word(name));
  return ExitCode::ok;
}

ExitCode run_campaign_export(const CampaignExportOptions& options, Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, options.campaign);
  const CampaignFile file = stored_campaign(connection, campaign);
  if (!options.dry_run) write_campaign(file, options.folder);
  if (context.json) {
    context.print("campaign-export", {{"campaign", campaign.name},
                                      {"folder", options.folder},
                                      {"n_readings", file.campaign.readings.size()},
                                      {"dry_run", options.dry_run}});
  } else {
    context.print(fmt::format(
        "{} campaign {}: {} readings to {}", options.dry_run ? "would export" : "exported",
        printable(campaign.name), file.campaign.readings.size(), printable(options.folder)));
  }
  return ExitCode::ok;
}

void setup_campaign_exchange(CLI::App& app, Context& context) {
  CLI::App& campaigns = noun(app, "campaign", "Campaigns: list, show, import, export");
  auto in = std::make_shared<CampaignImportOptions>();
  CLI::App* import = campaigns.add_subcommand("import", "Store a campaign/1 of another tool");
  import->add_option("FOLDER", in->folder, "Folder with campaign.json, or that file")->required();
  import->add_option("--name", in->name, "Name it is stored under (default: as the file says)");
  import->add_flag("--dry-run", in->dry_run, "Read and check all of it, store nothing");
  on_run(*import, context, in, run_campaign_import);

  auto out = std::make_shared<CampaignExportOptions>();
  CLI::App* exporting = campaigns.add_subcommand("export", "Write a campaign as campaign/1");
  exporting->add_option("CAMPAIGN", out->campaign, "Name or uuid")->required();
  exporting->add_option("FOLDER", out->folder, "Where campaign.json and readings.csv go")
      ->required();
  exporting->add_flag("--dry-run", out->dry_run, "Say what would be written, write nothing");
  on_run(*exporting, context, out, run_campaign_export);
}

}  // namespace trammel::cli
