#pragma once

#include "app/cli/campaign_exchange.hpp"

namespace trammel::cli {

/// `campaign import --grid FILE` and `--axis FILE`.
ExitCode import_positions(const CampaignImportOptions& options, Context& context);

}  // namespace trammel::cli
