#include "app/cli/commands.hpp"

#include "app/cli/campaign_exchange.hpp"
#include "app/cli/calibrate.hpp"
#include "app/cli/job.hpp"

namespace trammel::cli {

const std::vector<Setup>& commands() {
  static const std::vector<Setup> table = {
      setup_campaign_exchange,
      setup_calibrate,
      setup_job,
  };
  return table;
}

}  // namespace trammel::cli
