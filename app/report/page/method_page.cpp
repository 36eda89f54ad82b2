// Each method on each set of points, a fold each: the chosen one is open.

#include <fmt/format.h>

#include "app/report/page/source.hpp"

namespace trammel::report {

namespace {

Json summary_row(const ErrorTable& t) {
  const auto numbers = [&t](const Summary& s) {
    return fmt::format("{0:.{4}f} / {1:.{4}f} / {2:.{4}f} / {3:.{4}f}", s.mean, s.max, s.min, s.p95,
                       t.decimals);
  };
  std::string paper = "-";
  if (t.paper) {
    paper =
        fmt::format("{}: {:.4f} to {:.4f}", t.paper->table, t.paper->before[0], t.paper->after[0]);
  }
  return Json::array({t.method, t.figure, t.unit, name_of(t.standing),
                      t.after_predicted ? "predicted" : "measured again",
                      std::to_string(t.before.n), numbers(t.before), numbers(t.after),
                      t.improvement_pct ? fmt::format("{:+.1f} %", -*t.improvement_pct) : "-",
                      paper});
}

Json method_items(const Source& source, const Comparison& c) {
  Json items = Json::array(
      {map_figure(source, c, "map-" + id_of(source, c), "Position error: " + words_of(c))});
  for (const auto each : {histogram_figure, surface_figure, by_point_figure}) {
    for (const Figure figure : figures_of(source.measured.campaign.machine)) {
      if (Json item = each(source, c, figure); !item.is_null()) items.push_back(std::move(item));
    }
  }
  if (Json simulated = simulated_figure(source, c); !simulated.is_null()) {
    items.push_back(std::move(simulated));
  }
  return items;
}

std::string fold_title(const Source& source, const Comparison& c) {
  const Errors errors = errors_of(c.paired, Figure::position_mm);
  return fmt::format("{0}: mean {1:.{4}f} to {2:.{4}f} mm, {3}", words_of(c),
                     errors.summary_before.mean, errors.summary_after.mean,
                     c.paired.predicted ? "predicted" : "measured again",
                     decimals(source, Figure::position_mm));
}

}  // namespace

Json method_section(const Source& source) {
  const char* title = "Each method, map by map and point by point";
  if (source.comparisons.empty()) {
    return section("methods", title,
                   Json::array({absent("methods", "Errors before and after",
                                       "No calibration was judged on readings yet.")}));
  }
  Json items = Json::array(), rows = Json::array();
  const Comparison* chosen = headline(source);
  for (const Comparison& c : source.comparisons) {
    items.push_back(fold("method-" + id_of(source, c), fold_title(source, c), &c == chosen,
                         method_items(source, c)));
  }
  for (const ErrorTable& t : source.report.tables) rows.push_back(summary_row(t));
  items.push_back(fold(
      "all-errors", "All errors in one table", false,
      Json::array({table_beside_paper(
          source,
          {"errors", "All errors",
           "in-sample: the points that were fitted judge the fit. held-out: points "
           "no fit has seen. p95: 95 % of the errors are smaller."},
          {"method", "figure", "unit", "judged", "after is", "n", "before: mean / max / min / p95",
           "after: mean / max / min / p95", "change", "the paper's means"},
          rows)})));
  return section("methods", title, items);
}

}  // namespace trammel::report
