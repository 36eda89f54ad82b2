#include "app/job/next_points_plan.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/terminal/text.hpp"
#include "core/units.hpp"
#include "store/campaign.hpp"

namespace trammel::job {

Plan next_points_plan(const Json& diagnosis) {
  Plan plan;
  plan.name = kNextPoints;
  const Json state = diagnosis.value("next_state", Json::object());  // none in older versions
  plan.approach_mm = state.value("approach_mm", plan.approach_mm);
  for (const Json& p : diagnosis.at("next_points")) {
    PlannedPoint point;
    point.seq = static_cast<int>(plan.points.size()) + 1;
    point.target = {p.at("x_mm"), p.value("y_mm", 0.0), rad_from_deg(p.value("phi_deg", 0.0))};
    std::ranges::copy(p.at("approach").get<std::vector<int>>(), point.approach.begin());
    point.group = p.at("why");
    plan.points.push_back(point);
  }
  return plan;
}

store::Job last_diagnosis(store::Connection& connection, const std::string& campaign) {
  store::Id last = 0;
  const store::Id of = store::require_campaign(connection, campaign).id;
  for (const store::JobRow& row : store::list_jobs(connection, of)) {
    if (row.stage == "diagnose") last = row.id;
  }
  if (last == 0) {
    throw NotFoundError({.what = "the campaign has no diagnosis that could suggest points",
                         .where = {.field = "campaign"},
                         .got = campaign,
                         .hint = "trammel diagnose " + terminal::shell_word(campaign)});
  }
  return store::get_job(connection, last);
}

Plan stored_next_points(const store::Job& job) {
  if (job.data.stage != "diagnose") {
    throw InputError({.what = "only a diagnosis suggests points",
                      .where = {.field = "job"},
                      .got = fmt::format("job {}, of {}", job.id, job.data.stage)});
  }
  const Json details = Json::parse(job.data.result_json).at("details");
  Plan plan = next_points_plan(details);
  if (!plan.points.empty()) return plan;
  throw NotFoundError({.what = fmt::format("job {} suggests no points: it ends {}", job.id,
                                           details.at("verdict").get<std::string>())});
}

}  // namespace trammel::job
