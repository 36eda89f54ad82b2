// Where simulation and measurement part: what was named, how the gap closes, what could not be
// seen.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/report/from_job.hpp"
#include "app/report/page/source.hpp"

namespace trammel::report {

namespace {

const Json* find(const Json& object, const char* name) {
  return object.contains(name) ? &object.at(name) : nullptr;
}

std::string joined(const Json& names, const char* between) {
  std::string text;
  for (const Json& name : names) text += (text.empty() ? "" : between) + name.get<std::string>();
  return text;
}

std::string points_words(const std::vector<PointsOf>& points) {
  std::string text;
  for (const PointsOf& p : points) {
    text += fmt::format("{}{} points of {}", text.empty() ? "" : ", ", p.n, p.session);
  }
  return text.empty() ? "no new points" : text;
}

Json waterfall(const StoryRound& round, std::size_t number) {
  Json steps = Json::array();
  const auto value = [](const std::optional<double>& v) {
    return v ? Json(drawn(*v)) : Json(nullptr);
  };
  bool judged = false;
  for (const GapRow& row : round.gap) {
    steps.push_back({{"model", row.model},
                     {"fitted", value(row.identify_rms_mm)},
                     {"unseen", value(row.validate_rms_mm)}});
    judged = judged || row.validate_rms_mm.has_value();
  }
  return figure(
      {fmt::format("gap-{}", number),
       fmt::format("The gap at each step, round {}: {}", number, round.verdict),
       fmt::format("rms of measured - simulated per coordinate [mm]; pale: what this step closed. "
                   "Fitted: in-sample, {} more than the round before. {} A perfect model leaves "
                   "{:.4f} mm.",
                   points_words(round.fitted),
                   judged ? fmt::format("Unseen: held-out, {}.", points_words(round.judged))
                          : "No unseen readings: nothing judges it.",
                   round.noise_floor_mm)},
      "waterfall", {{"steps", steps}, {"floor", drawn(round.noise_floor_mm)}});
}

/// Decimals that show two digits of a standard deviation.
int decimals_of(double deviation) {
  if (!(deviation > 0)) return 6;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(deviation))), 0, 12);
}

Json effects_table(const StoryRound& last) {
  Json rows = Json::array();
  for (const EffectRow& e : last.effects) {
    for (const EffectRow::Value& v : e.values) {
      const int decimals = decimals_of(v.std);
      rows.push_back(Json::array({e.name, v.name, fmt::format("{:.{}f}", v.value, decimals),
                                  fmt::format("{:.{}f}", v.std, decimals), v.unit}));
    }
    if (!e.seqs.empty()) {
      rows.push_back(Json::array({e.name, "readings", fmt::format("{}", e.seqs.size()), "-", ""}));
    }
  }
  if (rows.empty()) return absent("effects", "Named effects", "No effect was named.");
  return table({"effects", "Named effects, values of the last round",
                "std: one standard deviation, from the fitted readings"},
               {"effect", "parameter", "value", "std", "unit"}, rows);
}

Json rivals_table(const StoryRound& last) {
  if (last.rivals.empty()) {
    return absent("rivals", "Rivals", "No other set of effects explains the readings as well.");
  }
  Json rows = Json::array();
  for (const RivalRow& r : last.rivals) {
    rows.push_back(Json::array(
        {r.names, r.structural ? "the same on these points" : fmt::format("{:.2g} : 1", r.odds)}));
  }
  return table(
      {"rivals", "Rivals: other sets of effects that explain the readings about as well", ""},
      {"effects", "odds for the named set"}, rows);
}

Json audit_table(const Json& details) {
  const Json* audit = find(details, "audit");
  if (audit == nullptr) return absent("audit", "What could be seen", "This job kept no audit.");
  Json rows = Json::array();
  for (const Json& row : *audit) {
    const Json& smallest = row.at("smallest_visible");
    const bool seen =
        smallest.is_number() && smallest.get<double>() <= row.at("usual_max").get<double>();
    std::string verdict = seen ? "would show" : "could not have been seen";
    if (const Json* needs = find(row, "needs")) {
      verdict +=
          ": needs " + (needs->is_string() ? needs->get<std::string>() : joined(*needs, ", "));
    }
    rows.push_back(
        Json::array({row.at("effect"), verdict,
                     smallest.is_number() ? fmt::format("{:.2g}", smallest.get<double>()) : "none",
                     fmt::format("{:g}", row.at("usual_max").get<double>()), row.at("unit"),
                     fmt::format("{:.1f} %", 100 * row.at("surviving_share").get<double>()),
                     joined(row.at("aliases"), ", ")}));
  }
  return table({"audit", "What these points could show, and what not",
                "smallest visible: at 80 % power, after the geometry was refitted; share: what the "
                "geometry cannot imitate; looks like: cannot be told apart on these points"},
               {"effect", "these points", "smallest visible", "usual at most", "unit", "share left",
                "looks like"},
               rows);
}

Json next_points(const Source& source, const Json& details) {
  const char* title = "Where to measure next";
  const Json* points = find(details, "next_points");
  if (points == nullptr || points->empty()) {
    return absent("next-points", title, "The last diagnosis needs no more points.");
  }
  Json fitted_targets = Json::array(), next = Json::array();
  for (const Walk& walk : source.measured.walks) {
    if (walk.session.compensation_job) continue;
    for (const Visit& v : walk.visits) {
      fitted_targets.push_back(
          Json::array({drawn(v.reading.target.x_mm), drawn(v.reading.target.y_mm)}));
    }
  }
  for (const Json& p : *points) {
    std::string approach;
    for (const Json& a : p.at("approach")) approach += a.get<int>() > 0 ? '+' : '-';
    next.push_back({{"x_mm", p.at("x_mm")},
                    {"y_mm", p.at("y_mm")},
                    {"phi_deg", p.at("phi_deg")},
                    {"approach", approach},
                    {"why", p.at("why")}});
  }
  return figure({"next-points", title,
                 fmt::format("{} points that would tell most [mm]: small marks are where was "
                             "measured. trammel plan and session run take them as they are.",
                             next.size())},
                "next-points", {{"measured", fitted_targets}, {"next", next}});
}

/// Points of the newest round that asked for some: the last may ask for none.
Json asking_details(const Source& source, const Json& last) {
  if (!last.at("next_points").empty()) return last;
  for (auto round = source.report.story.rbegin(); round != source.report.story.rend(); ++round) {
    if (round->n_next_points == 0) continue;
    const store::Job job = store::get_job(source.connection, round->job_id);
    return Json::parse(job.data.result_json).at("details");
  }
  return last;
}

}  // namespace

Json story_section(const Source& source) {
  const char* title = "Where simulation and measurement part, and why";
  const auto diagnosis = source.jobs.find("diagnose");
  if (diagnosis == source.jobs.end() || source.report.story.empty()) {
    return section("story", title,
                   Json::array({absent("gap", "The gap at each step",
                                       "No diagnosis was made: trammel diagnose CAMPAIGN.")}));
  }
  const Json details = Json::parse(diagnosis->second.data.result_json).at("details");
  std::vector<std::string> words;
  Json items = Json::array();
  std::size_t number = 0;
  for (const StoryRound& round : source.report.story) {
    std::string named;
    for (const EffectRow& e : round.effects) named += (named.empty() ? "" : " + ") + e.name;
    words.push_back(fmt::format("Round {} (job {}): {}; named {}; fitted {}.", ++number,
                                round.job_id, round.verdict, named.empty() ? "nothing" : named,
                                points_words(round.fitted)));
    items.push_back(waterfall(round, number));
  }
  if (const Json* notes = find(details, "notes")) {
    for (const Json& note : *notes) words.push_back(note.get<std::string>());
  }
  const StoryRound& last = source.report.story.back();
  items.push_back(effects_table(last));
  items.push_back(rivals_table(last));
  items.push_back(audit_table(details));
  items.push_back(next_points(source, asking_details(source, details)));
  return section("story", title, items, words);
}

}  // namespace trammel::report
