#include "app/cli/commands.hpp"

#include "app/cli/assess.hpp"
#include "app/cli/calibrate.hpp"
#include "app/cli/campaign.hpp"
#include "app/cli/campaign_exchange.hpp"
#include "app/cli/compare.hpp"
#include "app/cli/completion.hpp"
#include "app/cli/db.hpp"
#include "app/cli/diagnose.hpp"
#include "app/cli/emulate.hpp"
#include "app/cli/job.hpp"
#include "app/cli/man.hpp"
#include "app/cli/mechanism.hpp"
#include "app/cli/model.hpp"
#include "app/cli/plan.hpp"
#include "app/cli/protocol.hpp"
#include "app/cli/query.hpp"
#include "app/cli/reading.hpp"
#include "app/cli/report.hpp"
#include "app/cli/serve.hpp"
#include "app/cli/session.hpp"
#include "app/cli/session_control.hpp"

namespace trammel::cli {

const std::vector<Setup>& commands() {
  // One a line, in the order of a campaign.
  // clang-format off
  static const std::vector<Setup> table = {
      setup_demo,
      setup_protocol,
      setup_plan,
      setup_session,
      setup_session_control,
      setup_campaign,
      setup_campaign_exchange,
      setup_reading,
      setup_calibrate,
      setup_diagnose,
      setup_model,
      setup_job,
      setup_report,
      setup_serve,
      setup_assess,
      setup_compare,
      setup_mechanism,
      setup_emulate,
      setup_query,
      setup_db,
      setup_completion,
      setup_man,
  };
  // clang-format on
  return table;
}

}  // namespace trammel::cli
