// What decides: before and after with intervals, what was named, what is to be doubted, one map.

#include <fmt/format.h>

#include <algorithm>

#include "app/job/text.hpp"
#include "app/report/page/source.hpp"

namespace trammel::report {

namespace {

std::string with_interval(double mean, const std::optional<Interval>& interval) {
  return fmt::format("{:.4f}", mean) +
         (interval ? fmt::format("\n({:.4f} to {:.4f})", interval->low, interval->high) : "");
}

Json before_after_row(const Comparison& c, Figure figure) {
  const Errors errors = errors_of(c.paired, figure);
  const Summary &before = errors.summary_before, &after = errors.summary_after;
  return Json::array({fmt::format("{}{}\n{} [{}]", method_of(*c.job),
                                  c.paired.predicted ? " *" : "", word_of(figure), unit_of(figure)),
                      with_interval(before.mean, mean_interval(errors.before)),
                      with_interval(after.mean, mean_interval(errors.after)),
                      change_words(c, errors),
                      fmt::format("{:.4f}\n{:.4f}", before.p95, before.max),
                      fmt::format("{:.4f}\n{:.4f}", after.p95, after.max)});
}

/// The chosen method first, then the others on the same points.
Json before_after_table(const Source& source, const Comparison& best) {
  const Report& report = source.report;
  Json rows = Json::array();
  for (const Figure figure : figures_of(source.measured.campaign.machine)) {
    rows.push_back(before_after_row(best, figure));
  }
  for (const Comparison& c : source.comparisons) {
    if (&c == &best || c.group != best.group || c.standing != best.standing) continue;
    rows.push_back(before_after_row(c, Figure::position_mm));
  }
  if (report.floor_mean_mm) {
    rows.push_back(Json::array(
        {"a perfect robot", "", fmt::format("{:.4f}", *report.floor_mean_mm), "", "", ""}));
  }
  return table(
      {"before-after", fmt::format("Before and after on {}", set_words(best)),
       "In brackets: 95 % interval, points resampled. *: after is predicted, not measured again."},
      {"method\nerror", "mean before\n(95 % interval)", "mean after\n(95 % interval)",
       "change\n(95 % interval)", "before:\n95 %, max", "after:\n95 %, max"},
      rows);
}

/// A sentence as what it begins with, what it says, and how it ends: "alarm: THIS: why".
struct Parts {
  std::string head, middle, tail;
};
Parts parts_of(const std::string& sentence) {
  const std::size_t first = sentence.find(": "), last = sentence.rfind(": ");
  if (first == std::string::npos || first == last) return {"", sentence, ""};
  return {sentence.substr(0, first + 2), sentence.substr(first + 2, last - first - 2),
          sentence.substr(last)};
}

/// Sentences that differ in their middle alone become one.
std::vector<std::string> merged(const std::vector<std::string>& sentences) {
  std::vector<Parts> all;
  for (const std::string& sentence : sentences) {
    const Parts next = parts_of(sentence);
    const bool joins = !all.empty() && !next.head.empty() && all.back().head == next.head &&
                       all.back().tail == next.tail;
    if (joins) {
      all.back().middle += "; " + next.middle;
    } else {
      all.push_back(next);
    }
  }
  std::vector<std::string> lines;
  for (const Parts& p : all) lines.push_back(p.head + p.middle + p.tail);
  return lines;
}

/// Of all calibrations and of the report itself; what several methods say stands once.
Json warnings(const Source& source) {
  std::vector<std::pair<std::string, std::string>> found;  // who, what
  for (const store::Job* job : in_order(source.jobs)) {
    const Json result = Json::parse(job->data.result_json);
    std::vector<std::string> warned;
    for (const Json& sentence : result.value("words", Json::array())) {
      if (job::is_warning(sentence.get<std::string>())) warned.push_back(sentence);
    }
    for (const std::string& what : merged(warned)) {
      const std::string who = job->data.stage;
      const auto same =
          std::ranges::find_if(found, [&what](const auto& each) { return each.second == what; });
      if (same == found.end()) {
        found.emplace_back(who, what);
      } else {
        same->first += ", " + who;
      }
    }
  }
  std::vector<std::string> lines = source.report.remarks;
  for (const auto& [who, what] : found) lines.push_back(fmt::format("{}: {}", who, what));
  return sentences("warnings", "Warnings of the calibrations, and of this report", lines,
                   source.jobs.empty() ? "Nothing was calibrated yet." : "None.");
}

}  // namespace

Json verdict_section(const Source& source) {
  const char* title = "Position error before and after";
  const char* why = "No calibration of this campaign has readings to judge it.";
  const Comparison* best = headline(source);
  return section("verdict", "Verdict",
                 Json::array({best == nullptr ? absent("before-after", "Before and after", why)
                                              : before_after_table(source, *best),
                              named_table(source),
                              best == nullptr ? absent("headline", title, why)
                                              : map_figure(source, *best, "headline", title),
                              warnings(source)}));
}

}  // namespace trammel::report
