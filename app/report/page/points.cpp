// Errors point by point, before and after, and how they are spread.

#include <fmt/format.h>

#include "app/report/page/source.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

Json all_drawn(const std::vector<double>& values) {
  Json all = Json::array();
  for (const double value : values) all.push_back(drawn(value));
  return all;
}

std::string titled(const char* what, const Comparison& c, Figure figure) {
  return fmt::format("{} {}: {}", figure == Figure::position_mm ? "Position" : "Attitude", what,
                     words_of(c));
}

const std::optional<double>& floor_of(const Source& source, Figure figure) {
  return figure == Figure::position_mm ? source.report.floor_mean_mm : source.report.floor_mean_deg;
}

Json sides(const Source& source, const Errors& errors, Figure which) {
  const auto& floor = floor_of(source, which);
  return {{"unit", unit_of(which)},
          {"before", all_drawn(errors.before)},
          {"after", all_drawn(errors.after)},
          {"floor", floor ? Json(drawn(*floor)) : Json(nullptr)}};
}

}  // namespace

Json by_point_figure(const Source& source, const Comparison& c, Figure which) {
  Json data = sides(source, errors_of(c.paired, which), which);
  data["targets"] = Json::array();
  for (const Pair& pair : c.paired.pairs) {
    const Pose& target = pair.before->reading.target;
    data["targets"].push_back(fmt::format("point {}: ({:g}, {:g}) mm, {:g} deg", pair.before->point,
                                          drawn(target.x_mm), drawn(target.y_mm),
                                          drawn(deg_from_rad(target.phi_rad))));
  }
  return figure(
      {fmt::format("points-{}-{}", id_of(source, c), word_of(which)),
       titled("error by point", c, which),
       set_words(c) + (floor_of(source, which) ? ". Line: the mean of a perfect reading." : ".")},
      "by-point", std::move(data));
}

Json histogram_figure(const Source& source, const Comparison& c, Figure which) {
  const Errors errors = errors_of(c.paired, which);
  Json data = sides(source, errors, which);
  const char* small_unit = which == Figure::position_mm ? "um" : "mdeg";
  data["small_unit"] = small_unit;
  const auto limits = [](const Summary& s) {
    return Json{{"mean", drawn(s.mean)}, {"p95", drawn(s.p95)}, {"max", drawn(s.max)}};
  };
  data["limits"] = {{"before", limits(errors.summary_before)},
                    {"after", limits(errors.summary_after)}};
  return figure({fmt::format("histogram-{}-{}", id_of(source, c), word_of(which)),
                 titled("errors, how many of each size", c, which),
                 fmt::format("{}. Each side has its own scale: before in {}, after in {}. Lines: "
                             "95 % of the errors are smaller; the largest.",
                             set_words(c), unit_of(which), small_unit)},
                "histogram", std::move(data));
}

}  // namespace trammel::report
