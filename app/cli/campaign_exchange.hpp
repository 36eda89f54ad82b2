#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct CampaignImportOptions {
  std::string folder;
  std::string name;  // empty: as the file says
  bool dry_run = false;
};
struct CampaignExportOptions {
  std::string campaign;
  std::string folder;
  bool dry_run = false;
};

/// `campaign import` and `campaign export`: the format campaign/1.
void setup_campaign_exchange(CLI::App& app, Context& context);

ExitCode run_campaign_import(const CampaignImportOptions& options, Context& context);
ExitCode run_campaign_export(const CampaignExportOptions& options, Context& context);

}  // namespace trammel::cli
