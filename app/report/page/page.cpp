#include "app/report/page/page.hpp"

#include <fmt/format.h>

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
                    fmt::format("{:.{}f}", p.error_mm, test.of.decimals),
                    p.U_mm ? fmt::format("{:.{}f}", *p.U_mm, test.of.decimals) : "-",
                    name_of(test.verdicts[k])});
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
               const Gathered& gathered) {
  const Report& report = gathered.report;
  const Source source{.connection = connection,
                      .campaign = campaign,
                      .measured = gathered.measured,
                      .jobs = gathered.jobs,
                      .groups = gathered.groups,
                      .comparisons = gathered.comparisons,
                      .circles = gathered.circles,
                      .report = report};
  Json sections = Json::array();
  std::string answer = verdict(report);
  for (const auto section :
       {verdict_section, method_section, contest_section, story_section, residual_section,
        circle_section, fit_section, plan_section, facts_section}) {
    if (Json made = section(source); !made.is_null()) sections.push_back(std::move(made));
  }
  if (report.tolerance) {
    sections.insert(sections.begin() + 1, tolerance_section(*report.tolerance));
    answer = tolerance_words(*report.tolerance) + ". " + answer;
  }
  return {{"schema", "trammel/report-page/1"},
          {"campaign", report.campaign},
          {"kind", report.simulated ? "simulated" : "real"},
          {"verdict", answer},
          {"decimals_mm", report.decimals_mm},
          {"tool_version", store::this_program().tool_version},
          {"sections", sections}};
}

}  // namespace trammel::report
