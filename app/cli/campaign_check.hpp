#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct CampaignCheckOptions {
  std::string campaign;  // a folder or campaign.json where there is one, else name or uuid
};

/// `campaign check NAME | DIR`: what the screen finds, exit 4 where it is gross, 5 where it is
/// doubtful.
void setup_campaign_check(Command campaigns, Context& context);

ExitCode run_campaign_check(const CampaignCheckOptions& options, Context& context);

}  // namespace trammel::cli
