#include "app/report/page/page.hpp"

#include "app/report/gather.hpp"
#include "app/report/page/source.hpp"
#include "app/report/print.hpp"
#include "store/provenance.hpp"

namespace trammel::report {

Json page_json(store::Connection& connection, const store::CampaignRow& campaign) {
  const Report report = gather(connection, campaign);
  const Measured measured = load_measured(connection, campaign);
  const Jobs jobs = chosen_jobs(connection, campaign.id, measured);
  const std::vector<const store::Job*> methods = in_order(jobs);
  const std::vector<Group> groups = baseline_groups(measured);
  const std::vector<Comparison> compared = comparisons(measured, groups, methods);
  const std::vector<Comparison> circles = circle_comparison(measured, groups, methods);
  const Source source{.connection = connection,
                      .campaign = campaign,
                      .measured = measured,
                      .jobs = jobs,
                      .groups = groups,
                      .comparisons = compared,
                      .circles = circles,
                      .report = report};
  Json sections = Json::array();
  for (const auto section :
       {verdict_section, method_section, contest_section, story_section, residual_section,
        circle_section, fit_section, plan_section, facts_section}) {
    sections.push_back(section(source));
  }
  return {{"schema", "trammel/report-page/1"},
          {"campaign", report.campaign},
          {"kind", report.simulated ? "simulated" : "real"},
          {"verdict", verdict(report)},
          {"tool_version", store::this_program().tool_version},
          {"sections", sections}};
}

}  // namespace trammel::report
