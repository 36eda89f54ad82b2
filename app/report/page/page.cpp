#include "app/report/page/page.hpp"

#include <fmt/format.h>

#include "app/report/gather.hpp"
#include "app/report/page/source.hpp"
#include "app/report/print.hpp"
#include "store/provenance.hpp"

namespace trammel::report {

namespace {

Json tolerance_section(const ToleranceTest& test) {
  Json rows = Json::array();
  for (std::size_t k = 0; k < test.verdicts.size(); ++k) {
    const JudgedPoint& p = test.of.points[k];
    rows.push_back({fmt::format("{:.3f}", p.x_mm), fmt::format("{:.3f}", p.y_mm),
                    fmt::format("{:.4f}", p.error_mm),
                    p.U_mm ? fmt::format("{:.4f}", *p.U_mm) : "-", name_of(test.verdicts[k])});
  }
  const std::string caption =
      "U (k = 2): " + test.of.U_from +
      ". A point passes where error and U are within the tolerance together, fails where the error "
      "less U is beyond it (ISO 14253-1).";
  return section("tolerance", "Tolerance",
                 Json::array({table({"tolerance-points", "Point by point", caption},
                                    {"x mm", "y mm", "error mm", "U mm", "verdict"}, rows)}),
                 {tolerance_words(test) + "."});
}

}  // namespace

Json page_json(store::Connection& connection, const store::CampaignRow& campaign,
               const std::optional<double>& tolerance_mm) {
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
  std::string answer = verdict(report);
  for (const auto section :
       {verdict_section, method_section, contest_section, story_section, residual_section,
        circle_section, fit_section, plan_section, facts_section}) {
    sections.push_back(section(source));
  }
  if (tolerance_mm) {
    const ToleranceTest test =
        tolerance_test(judged_points(connection, campaign, report), *tolerance_mm);
    sections.insert(sections.begin() + 1, tolerance_section(test));
    answer = tolerance_words(test) + ". " + answer;
  }
  return {{"schema", "trammel/report-page/1"},
          {"campaign", report.campaign},
          {"kind", report.simulated ? "simulated" : "real"},
          {"verdict", answer},
          {"tool_version", store::this_program().tool_version},
          {"sections", sections}};
}

}  // namespace trammel::report
