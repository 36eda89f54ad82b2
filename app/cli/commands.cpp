#include "app/cli/commands.hpp"

#include "app/cli/campaign_exchange.hpp"

namespace trammel::cli {

const std::vector<Setup>& commands() {
  static const std::vector<Setup> table = {
      setup_campaign_exchange,
  };
  return table;
}

}  // namespace trammel::cli
