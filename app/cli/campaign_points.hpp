#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct CampaignPointsOptions {
  std::string file;
  std::string format, unit, date;
  std::string decimal = ".";
  std::string by;
  int nests = 0;
};

/// `campaign points`: what a tracker's file holds, without importing it.
void setup_campaign_points(Command campaigns, Context& context);
ExitCode run_campaign_points(const CampaignPointsOptions& options, Context& context);

}  // namespace trammel::cli
