#include "app/cli/commands.hpp"

#include "app/cli/calibrate.hpp"
#include "app/cli/campaign.hpp"
#include "app/cli/campaign_exchange.hpp"
#include "app/cli/db.hpp"
#include "app/cli/job.hpp"
#include "app/cli/query.hpp"
#include "app/cli/reading.hpp"

namespace trammel::cli {

const std::vector<Setup>& commands() {
  static const std::vector<Setup> table = {
      setup_campaign_exchange, setup_campaign, setup_reading, setup_query, setup_db,
      setup_calibrate,         setup_job,
  };
  return table;
}

}  // namespace trammel::cli
