// Circles as they were driven, their deviations magnified.

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "app/files/numbers.hpp"
#include "app/report/page/source.hpp"
#include "app/report/print.hpp"
#include "core/judge/deviation.hpp"

namespace trammel::report {

namespace {

// Of the largest radius, as drawn: the largest deviation, and a division of its scale at most.
constexpr double kWanted = 0.25, kDivision = 0.1;

Json circle_json(const CircleRow& row, const std::vector<const Pair*>& pairs) {
  Json points = Json::array();
  for (const Pair* pair : pairs) {
    const Pose& target = pair->before->reading.target;
    const Pose& before = *pair->before->reading.measured;
    points.push_back(
        Json::array({drawn(target.x_mm), drawn(target.y_mm), drawn(before.x_mm - target.x_mm),
                     drawn(before.y_mm - target.y_mm), drawn(pair->after.x_mm - target.x_mm),
                     drawn(pair->after.y_mm - target.y_mm)}));
  }
  return {{"name", row.name},
          {"x_mm", row.x_mm},
          {"y_mm", row.y_mm},
          {"radius_mm", row.radius_mm},
          {"points", points}};
}

std::string deviation_words(const CircleDeviation& d, int decimals) {
  return fmt::format("({0:+.{3}f}, {1:+.{3}f}), {2:+.{3}f}", rounded(d.centre_x_mm, decimals),
                     rounded(d.centre_y_mm, decimals), rounded(d.radius_mm, decimals), decimals);
}

}  // namespace

Json circle_section(const Source& source) {
  const std::string title = "Circles, deviations magnified" + of_the_paper(source, "Fig. 20");
  Json items = Json::array();
  if (source.circles.empty() || !source.report.circles) {
    items.push_back(absent("circles", title, "This campaign has no points on circles."));
    return section("circles", "Circles", items);
  }
  const int mm = decimals(source, Figure::position_mm);
  std::map<std::string, std::vector<const Pair*>> by_role;
  double largest = 0, radius = 0;
  for (const Comparison& c : source.circles) {
    for (const Pair& pair : c.paired.pairs) {
      const Pose& target = pair.before->reading.target;
      by_role[pair.before->role].push_back(&pair);
      largest = std::max({largest, position_error_mm(*pair.before->reading.measured, target),
                          position_error_mm(pair.after, target)});
    }
  }
  for (const CircleRow& row : source.report.circles->rows) radius = std::max(radius, row.radius_mm);
  const double factor = magnification(largest, kWanted * radius);
  const double division = magnification(factor, kDivision * radius);
  Json circles = Json::array(), rows = Json::array();
  for (const CircleRow& row : source.report.circles->rows) {
    circles.push_back(circle_json(row, by_role[row.name]));
    rows.push_back(Json::array(
        {row.name, fmt::format("({:g}, {:g}) R {:g}", row.x_mm, row.y_mm, row.radius_mm),
         std::to_string(row.n), deviation_words(row.before, mm), deviation_words(row.after, mm)}));
  }
  std::string judged;
  for (const Comparison& c : source.circles) {
    judged += fmt::format("{} {}, ", points_in_words(c.paired.pairs.size()), name_of(c.standing));
  }
  const Comparison& first = source.circles.front();
  judged += fmt::format("after: {}, {}", method_words(method_of(*first.job)),
                        first.paired.predicted ? "predicted" : "measured again");
  items.push_back(figure(
      {"circles", title,
       fmt::format("{}. Each point is drawn {:g} times as far from its target as it was; "
                   "scale: {:g} um per division, from one grey ring to the next.",
                   judged, factor, 1000 * division)},
      "circles", {{"magnification", factor}, {"division_mm", division}, {"circles", circles}}));
  rows.push_back(Json::array(
      {"mean of absolute values", "", "",
       deviation_words(mean_deviation(*source.report.circles, &CircleRow::before), mm),
       deviation_words(mean_deviation(*source.report.circles, &CircleRow::after), mm)}));
  if (const auto printed = published_circles(source.report)) {
    rows.push_back(
        Json::array({"the paper's, Table XI", "", "", "-", deviation_words(*printed, mm)}));
  }
  items.push_back(table(
      {"circle-deviations", "Least-squares circles less the circles asked for", "mm; " + judged},
      {"circle", "wanted [mm]", "n", "before: (centre x, y), radius [mm]",
       "after: (centre x, y), radius [mm]"},
      rows));
  return section("circles", "Circles", items);
}

}  // namespace trammel::report
