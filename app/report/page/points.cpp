// Errors point by point, before and after.

#include <fmt/format.h>

#include <cmath>

#include "app/report/page/source.hpp"
#include "core/judge/deviation.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

Json by_point(const Source& source, const Comparison& c, bool position) {
  const auto size = [position](const Pose& pose, const Pose& target) {
    return drawn(position ? position_error_mm(pose, target)
                          : deg_from_rad(attitude_error_rad(pose, target)));
  };
  Json before = Json::array(), after = Json::array(), targets = Json::array();
  for (const Pair& pair : c.paired.pairs) {
    const Reading& reading = pair.before->reading;
    before.push_back(size(*reading.measured, reading.target));
    after.push_back(size(pair.after, reading.target));
    targets.push_back(fmt::format("point {}: ({:g}, {:g}) mm, {:g} deg", pair.before->point,
                                  drawn(reading.target.x_mm), drawn(reading.target.y_mm),
                                  drawn(deg_from_rad(reading.target.phi_rad))));
  }
  const auto& floor = position ? source.report.floor_mean_mm : source.report.floor_mean_deg;
  Json data = {{"unit", position ? "mm" : "deg"},
               {"before", before},
               {"after", after},
               {"targets", targets},
               {"floor", floor ? Json(drawn(*floor)) : Json(nullptr)}};
  return figure(
      {fmt::format("points-{}-{}", id_of(source, c), position ? "position" : "attitude"),
       fmt::format("{} error by point: {}", position ? "Position" : "Attitude", words_of(c)),
       set_words(c) + (floor ? ". Line: the mean of a perfect reading." : ".")},
      "by-point", std::move(data));
}

Json summary_row(const ErrorTable& t) {
  const auto numbers = [](const Summary& s) {
    return fmt::format("{:.4f} / {:.4f} / {:.4f} / {:.4f}", s.mean, s.max, s.min, s.p95);
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

}  // namespace

Json point_section(const Source& source) {
  Json items = Json::array(), rows = Json::array();
  for (const ErrorTable& t : source.report.tables) rows.push_back(summary_row(t));
  if (!rows.empty()) {
    items.push_back(table(
        {"errors", "All errors",
         "in-sample: the points that were fitted judge the fit. held-out: points "
         "no fit has seen. p95: 95 % of the errors are smaller."},
        {"method", "figure", "unit", "judged", "after is", "n", "before: mean / max / min / p95",
         "after: mean / max / min / p95", "change", "the paper's means"},
        rows));
  }
  for (const Comparison& c : source.comparisons) {
    items.push_back(by_point(source, c, true));
    items.push_back(by_point(source, c, false));
  }
  if (items.empty()) {
    items.push_back(absent("points", "Errors by point", "No calibration was judged yet."));
  }
  return section("points", "Position and attitude errors by point", items, source.report.remarks);
}

}  // namespace trammel::report
