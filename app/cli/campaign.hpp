#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct CampaignListOptions {};
struct CampaignShowOptions {
  std::string campaign;
};

/// `campaign list` and `campaign show`.
void setup_campaign(Command app, Context& context);

ExitCode run_campaign_list(const CampaignListOptions& options, Context& context);
ExitCode run_campaign_show(const CampaignShowOptions& options, Context& context);

}  // namespace trammel::cli
