#include "app/cli/commands.hpp"

#include "app/cli/archive.hpp"
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
#include "app/cli/licenses.hpp"
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
#include "app/cli/template.hpp"

namespace trammel::cli {

const std::vector<ProgramCommand>& commands() {
  // One a line, in the order of a campaign.
  // clang-format off
  static const std::vector<ProgramCommand> table = {
      {"demo", setup_demo},
      {"template", setup_template},
      {"protocol", setup_protocol},
      {"plan", setup_plan},
      {"session", setup_session},
      {"session", setup_session_control},
      {"campaign", setup_campaign},
      {"campaign", setup_campaign_exchange},
      {"reading", setup_reading},
      {"calibrate", setup_calibrate},
      {"diagnose", setup_diagnose},
      {"model", setup_model},
      {"job", setup_job},
      {"report", setup_report},
      {"serve", setup_serve},
      {"assess", setup_assess},
      {"compare", setup_compare},
      {"mechanism", setup_mechanism},
      {"emulate", setup_emulate},
      {"query", setup_query},
      {"db", setup_db},
      {"archive", [](Command app, Context& context) { setup_archive(app, context, {}); }},
      {"licenses", setup_licenses},
      {nullptr, setup_completion},
      {nullptr, setup_man},
  };
  // clang-format on
  return table;
}

}  // namespace trammel::cli
