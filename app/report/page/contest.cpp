// Methods side by side, with intervals and the noise floor.

#include <fmt/format.h>

#include "app/report/page/source.hpp"

namespace trammel::report {

namespace {

Json bar(const Comparison& c) {
  const Errors errors = errors_of(c.paired, Figure::position_mm);
  Json json = {{"method", method_of(*c.job) + (c.paired.predicted ? " *" : "")},
               {"judged", name_of(c.standing)},
               {"n", errors.after.size()},
               {"before", drawn(errors.summary_before.mean)},
               {"after", drawn(errors.summary_after.mean)}};
  if (const auto interval = mean_interval(errors.after)) {
    json["low"] = drawn(interval->low);
    json["high"] = drawn(interval->high);
  }
  return json;
}

Json folds(const Source& source) {
  const char* title = "All methods on the same folds";
  const auto contest = source.jobs.find("contest");
  if (contest == source.jobs.end()) {
    return absent("folds", title,
                  "The methods were not put to a contest: trammel calibrate contest CAMPAIGN.");
  }
  const Json details = Json::parse(contest->second.data.result_json).at("details");
  Json rows = Json::array();
  const int mm = decimals(source, Figure::position_mm);
  const std::string picked = details.at("picked");
  for (const Json& row : details.at("table")) {
    const std::string name = row.at("method");
    if (row.contains("failed")) {
      rows.push_back(Json::array({name, "could not run", "", "", row.at("failed")}));
      continue;
    }
    std::string depends;
    for (const auto& [what, share] : row.at("depends_on").items()) {
      depends += fmt::format("{}{} ({:.0f} %)", depends.empty() ? "" : ", ", what,
                             100 * share.get<double>());
    }
    const auto number = [&row, mm](const char* key) {
      return fmt::format("{:.{}f}", row.at(key).get<double>(), mm);
    };
    rows.push_back(Json::array({name + (name == picked ? " (picked)" : ""), number("mean_mm"),
                                number("p95_mm"), number("max_mm"),
                                depends.empty() ? "nothing recorded" : depends}));
  }
  return table({"folds", title,
                fmt::format("Position errors [mm], held-out: each reading predicted without its "
                            "spatial block; mean length of a perfect reading {:.{}f} mm.",
                            details.at("floor_mean_mm").get<double>(), mm)},
               {"method", "mean [mm]", "p95 [mm]", "max [mm]", "what is left goes with"}, rows);
}

}  // namespace

Json contest_section(const Source& source) {
  const char* title = "Mean position error that each method leaves";
  Json items = Json::array(), bars = Json::array();
  bool predicted = false;
  for (const Comparison& c : source.comparisons) {
    bars.push_back(bar(c));
    predicted = predicted || c.paired.predicted;
  }
  const auto& floor = source.report.floor_mean_mm;
  if (!bars.empty()) {
    items.push_back(figure(
        {"contest", title,
         std::string("mm, on one baseline; whiskers: 95 % interval of the mean "
                     "(Student's t over the points)") +
             (floor ? fmt::format("; line: mean length of a perfect reading, {:.{}f} mm", *floor,
                                  decimals(source, Figure::position_mm))
                    : "") +
             (predicted ? "; *: predicted from the readings before, not measured again." : ".")},
        "contest", {{"bars", bars}, {"floor", floor ? Json(drawn(*floor)) : Json(nullptr)}}));
  }
  items.push_back(folds(source));
  std::vector<std::string> words;
  if (const auto& c = source.report.contest) {
    words.push_back(fmt::format(
        "{} leaves the smaller error at {} of the same {} unseen points than {}; mean difference "
        "{} - {} = {:+.{}f} mm, 95 % interval +-{:.{}f} mm.",
        c->b, c->b_better, c->n, c->a, c->a, c->b, c->mean_difference_mm, source.report.decimals_mm,
        c->half_width_mm, source.report.decimals_mm));
  }
  return section("contest", "The contest of methods", items, words);
}

}  // namespace trammel::report
