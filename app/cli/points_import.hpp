#pragma once

#include <string>

#include "app/cli/campaign_exchange.hpp"

namespace trammel::cli {

/// `campaign import --points`: makes readings of a tracker's file by a layout.
ExitCode import_points(const CampaignImportOptions& options, Context& context);

/// mm as tenths of um.
std::string um_text(double mm);

}  // namespace trammel::cli
