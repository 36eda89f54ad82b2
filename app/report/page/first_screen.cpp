// What decides: before and after with intervals, what was named, what is to be doubted, one map.

#include <fmt/format.h>

#include <algorithm>

#include "app/job/text.hpp"
#include "app/report/page/source.hpp"

namespace trammel::report {

namespace {

std::string with_interval(double mean, const std::optional<Interval>& interval, int decimals) {
  return fmt::format("{:.{}f}", mean, decimals) +
         (interval
              ? fmt::format("\n({0:.{2}f} to {1:.{2}f})", interval->low, interval->high, decimals)
              : "");
}

Json before_after_row(const Source& source, const Comparison& c, Figure figure) {
  const int digits = decimals(source, figure);
  const Errors errors = errors_of(c.paired, figure);
  const Summary &before = errors.summary_before, &after = errors.summary_after;
  return Json::array({fmt::format("{}{}\n{} [{}]", method_of(*c.job),
                                  c.paired.predicted ? " *" : "", word_of(figure), unit_of(figure)),
                      with_interval(before.mean, mean_interval(errors.before), digits),
                      with_interval(after.mean, mean_interval(errors.after), digits),
                      change_words(c, errors),
                      fmt::format("{0:.{2}f}\n{1:.{2}f}", before.p95, before.max, digits),
                      fmt::format("{0:.{2}f}\n{1:.{2}f}", after.p95, after.max, digits)});
}

/// The chosen method first, then the others on the same points.
Json before_after_table(const Source& source, const Comparison& best) {
  const Report& report = source.report;
  Json rows = Json::array();
  bool alike = true;  // whether "after" is known in one way
  for (const Figure figure : figures_of(source.measured.campaign.machine)) {
    rows.push_back(before_after_row(source, best, figure));
  }
  for (const Comparison& c : source.comparisons) {
    if (&c == &best || c.group != best.group || c.standing != best.standing) continue;
    rows.push_back(before_after_row(source, c, Figure::position_mm));
    alike = alike && c.paired.predicted == best.paired.predicted;
  }
  if (report.floor_mean_mm) {
    rows.push_back(Json::array({"a perfect robot", "",
                                fmt::format("{:.{}f}", *report.floor_mean_mm, report.decimals_mm),
                                "", "", ""}));
  }
  return table(
      {"before-after",
       fmt::format("Before and after on {}", alike ? set_words(best) : judged_words(best)),
       std::string("In brackets: 95 % interval of the mean (Student's t over the points).") +
           (alike && !best.paired.predicted ? "" : " *: after is predicted, not measured again.")},
      {"method\nerror", "mean before\n(95 % interval)", "mean after\n(95 % interval)",
       "change\n(95 % interval)", "before:\n95 %, max", "after:\n95 %, max"},
      rows);
}

/// A sentence as what it begins with, what it says, and how it ends: "alarm: THIS: why".
struct Parts {
  std::string head, middle, tail;
  int times = 1;
};
Parts parts_of(const std::string& sentence) {
  const std::size_t first = sentence.find(": "), last = sentence.rfind(": ");
  if (first == std::string::npos || first == last) return {"", sentence, ""};
  return {sentence.substr(0, first), sentence.substr(first, last - first), sentence.substr(last)};
}

/// Sentences that differ in their middle alone become one, with their number.
std::vector<std::string> merged(const std::vector<std::string>& sentences) {
  std::vector<Parts> all;
  for (const std::string& sentence : sentences) {
    const Parts next = parts_of(sentence);
    const bool joins = !all.empty() && !next.head.empty() && all.back().head == next.head &&
                       all.back().tail == next.tail;
    if (joins) {
      all.back().middle += ";" + next.middle.substr(1);
      ++all.back().times;
    } else {
      all.push_back(next);
    }
  }
  std::vector<std::string> lines;
  for (const Parts& p : all) {
    lines.push_back(p.head + (p.times > 1 ? fmt::format(" ({} times)", p.times) : "") + p.middle +
                    p.tail);
  }
  return lines;
}

/// Whether readings that came after a fit judge it by now, whatever the job could say then.
bool is_judged(const Source& source, const store::Job& job) {
  return std::ranges::any_of(source.comparisons, [&job](const Comparison& c) {
    return c.job == &job && c.standing == Standing::unseen;
  });
}

std::vector<std::string> warnings_of(const Source& source, const store::Job& job) {
  const Json result = Json::parse(job.data.result_json);
  std::vector<std::string> warned;
  for (const Json& each : result.value("words", Json::array())) {
    const std::string sentence = each.get<std::string>();
    if (!job::is_warning(sentence)) continue;
    if (job::is_of_no_held_out(sentence) && is_judged(source, job)) continue;
    warned.push_back(sentence);
  }
  return merged(warned);
}

/// Of all calibrations and of the report itself, the chosen one's first; what several methods say
/// stands once.
Json warnings(const Source& source, const Comparison* best) {
  struct Found {
    std::string who, what;
    bool chosen;
  };
  std::vector<Found> found;
  for (const store::Job* job : in_order(source.jobs)) {
    const bool chosen = best != nullptr && best->job == job;
    for (const std::string& what : warnings_of(source, *job)) {
      const auto same = std::ranges::find(found, what, &Found::what);
      if (same == found.end()) {
        found.push_back({method_of(*job), what, chosen});
      } else {
        same->who += ", " + method_of(*job);
        same->chosen = same->chosen || chosen;
      }
    }
  }
  std::vector<std::string> lines;
  const auto add = [&](bool chosen) {
    for (const Found& f : found) {
      if (f.chosen == chosen) lines.push_back(fmt::format("{}: {}", f.who, f.what));
    }
  };
  add(true);
  lines.insert(lines.end(), source.report.remarks.begin(), source.report.remarks.end());
  add(false);
  return sentences("warnings", "Warnings of the calibrations, and of this report", lines,
                   source.jobs.empty() ? "Nothing was calibrated yet." : "None.");
}

}  // namespace

Json verdict_section(const Source& source) {
  const Comparison* best = headline(source);
  Json items = Json::array(
      {best == nullptr ? absent("before-after", "Before and after",
                                "No calibration of this campaign has readings to judge it.")
                       : before_after_table(source, *best),
       named_table(source)});
  if (best != nullptr) {
    items.push_back(map_figure(source, *best, "headline", "Position error before and after"));
  }
  items.push_back(warnings(source, best));
  return section("verdict", "Verdict", items);
}

}  // namespace trammel::report
