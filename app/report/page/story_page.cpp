// Where simulation and measurement part: what was named, how the gap closes, what could not be
// seen.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/job/next_points_plan.hpp"
#include "app/report/from_job.hpp"
#include "app/report/page/source.hpp"
#include "app/report/print.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/text.hpp"
#include "core/judge/deviation.hpp"
#include "core/mechanism/displacements.hpp"
#include "core/units.hpp"

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
    text += fmt::format("{}{} of {}", text.empty() ? "" : ", ",
                        points_in_words(static_cast<std::size_t>(p.n)), p.session);
  }
  return text.empty() ? "no new points" : text;
}

Json waterfall(const Source& source, const StoryRound& round, std::size_t number) {
  Json steps = Json::array();
  const auto value = [](const std::optional<double>& v) {
    return v ? Json(drawn(*v)) : Json(nullptr);
  };
  bool judged = false;
  for (const GapRow& row : round.gap) {
    steps.push_back({{"model", row.model + (row.tried ? ", tried" : "")},
                     {"fitted", value(row.identify_rms_mm)},
                     {"unseen", value(row.validate_rms_mm)}});
    judged = judged || row.validate_rms_mm.has_value();
  }
  return figure(
      {fmt::format("gap-{}", number),
       fmt::format("The gap at each step, round {}: {}", number, round.verdict),
       fmt::format("rms of measured - simulated per coordinate [mm]; pale: what this step closed. "
                   "Fitted: in-sample, {} more than the round before. {} A perfect model leaves "
                   "{:.{}f} mm.",
                   points_words(round.fitted),
                   judged ? fmt::format("Unseen: held-out, {}.", points_words(round.judged))
                          : "No unseen readings: nothing judges it.",
                   round.noise_floor_mm, decimals(source, Figure::position_mm))},
      "waterfall", {{"steps", steps}, {"floor", drawn(round.noise_floor_mm)}});
}

/// Decimals that show two digits of an uncertainty.
int decimals_of(double U) {
  if (!(U > 0)) return 6;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(U))), 0, 12);
}

/// "k_1 0.00377 +- 0.00030, k_2 0.00251 +- 0.00030"; the unit where it is another than the one
/// before.
std::string value_words(const EffectRow& effect) {
  std::string text;
  for (std::size_t k = 0; k < effect.values.size(); ++k) {
    const EffectRow::Value& v = effect.values[k];
    const double U = 2 * v.std;
    const int decimals = decimals_of(U);
    const bool last = k + 1 == effect.values.size() || effect.values[k + 1].unit != v.unit;
    text += fmt::format("{}{} {:.{}f} +- {:.{}f}{}", text.empty() ? "" : ", ", v.name, v.value,
                        decimals, U, decimals, last && v.unit != "1" ? " " + v.unit : "");
  }
  if (!effect.seqs.empty()) text = terminal::counted(effect.seqs.size(), "reading");
  return text;
}

std::string chance_words(const EffectRow& effect) {
  if (!effect.seqs.empty()) return "left out of all fits";
  return fmt::format("{:.1f} % explained; chance {}", 100 * effect.share_of_gap,
                     effect.p < 1e-6 ? "< 1e-6" : fmt::format("{:.1g}", effect.p));
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
    const Json* usual = find(row, "usual_max");  // diagnoses of older versions state none
    const bool seen = smallest.is_number() && usual != nullptr && smallest <= *usual;
    std::string verdict = seen ? "would show" : usual == nullptr ? "-" : "could not have been seen";
    if (const Json* needs = find(row, "needs")) {
      verdict +=
          ": needs " + (needs->is_string() ? needs->get<std::string>() : joined(*needs, ", "));
    }
    rows.push_back(Json::array(
        {row.at("effect"), verdict,
         smallest.is_number() ? fmt::format("{:.2g}", smallest.get<double>()) : "none",
         usual == nullptr ? "-" : fmt::format("{:g}", usual->get<double>()), row.at("unit"),
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

/// Whether a visit is what a point asks for: there, turned and approached so.
bool answers(const Visit& visit, const PlannedPoint& asked) {
  constexpr double kSame = 1e-6;  // mm and rad: a plan keeps nine decimals
  const Eigen::Vector3d off = pose_difference(visit.reading.target, asked.target);
  if (off.cwiseAbs().maxCoeff() > kSame) return false;
  const Conditions& c = visit.reading.conditions;
  const Eigen::Vector3d came = directions_of(c.cmd_mm - c.from_mm);
  for (int i = 0; i < kChains; ++i) {
    const int from = asked.approach[static_cast<std::size_t>(i)];
    if (from != 0 && came[i] != from) return false;
  }
  return true;
}

/// The points that the last diagnosis asks for, less those measured since.
std::vector<PlannedPoint> still_asked(const Source& source, const store::Job& job,
                                      const Json& details) {
  std::vector<PlannedPoint> points = job::next_points_plan(details).points;
  const auto& used = job.data.sessions;
  for (const Walk& walk : source.measured.walks) {
    if (std::ranges::find(used, walk.session.id) != used.end()) continue;
    for (const Visit& visit : walk.visits) {
      const auto met = std::ranges::find_if(
          points, [&visit](const PlannedPoint& asked) { return answers(visit, asked); });
      if (met != points.end()) points.erase(met);
    }
  }
  return points;
}

Json next_points(const Source& source, const store::Job& job, const Json& details) {
  const char* title = "Where to measure next";
  const std::vector<PlannedPoint> points = still_asked(source, job, details);
  if (points.empty()) {
    return absent(
        "next-points", title,
        details.at("next_points").empty()
            ? "The last diagnosis needs no more points."
            : "All points that the last diagnosis asked for are measured: diagnose again.");
  }
  Json fitted_targets = Json::array(), next = Json::array();
  for (const Walk& walk : source.measured.walks) {
    if (walk.session.compensated()) continue;
    for (const Visit& v : walk.visits) {
      fitted_targets.push_back(
          Json::array({drawn(v.reading.target.x_mm), drawn(v.reading.target.y_mm)}));
    }
  }
  for (const PlannedPoint& p : points) {
    std::string approach;
    for (const int a : p.approach) approach += a > 0 ? '+' : a < 0 ? '-' : '0';
    next.push_back({{"x_mm", drawn(p.target.x_mm)},
                    {"y_mm", drawn(p.target.y_mm)},
                    {"phi_deg", drawn(deg_from_rad(p.target.phi_rad))},
                    {"approach", approach},
                    {"why", p.group}});
  }
  return figure({"next-points", title,
                 fmt::format("{} that would decide most [mm]; small marks are where was measured. "
                             "Beside each its orientation in deg and the direction in which each "
                             "drive approaches it. `trammel plan create next-points` writes them.",
                             points_in_words(next.size()))},
                "next-points", {{"measured", fitted_targets}, {"next", next}});
}

}  // namespace

Json named_table(const Source& source) {
  const char* title = "Named effects";
  if (source.report.story.empty()) {
    return absent("named", title,
                  "No diagnosis was made: trammel diagnose " +
                      terminal::shell_word(source.report.campaign) + ".");
  }
  const StoryRound& last = source.report.story.back();
  Json rows = Json::array();
  for (const EffectRow& e : last.effects) {
    rows.push_back(Json::array({e.name, value_words(e), chance_words(e)}));
  }
  for (const RivalRow& r : last.rivals) {
    rows.push_back(
        Json::array({"rival: " + r.names, "explains the readings about as well",
                     r.structural ? "the same on these points"
                                  : fmt::format("{:.2g} : 1 for the named set", r.odds)}));
  }
  for (const auto& [name, probability] : last.may_also_hold) {
    const bool named = std::ranges::count(last.effects, name, &EffectRow::name) > 0;
    rows.push_back(Json::array(
        {name, named ? "further parameters of it may also hold" : "not named, may also hold",
         fmt::format("{:.0f} %", 100 * probability)}));
  }
  if (rows.empty()) rows.push_back(Json::array({"none", "no effect was named", "-"}));
  return table({"named", fmt::format("{}; the diagnosis ends {}", title, last.verdict),
                "+-: U (k = 2). Doubt: share of what is explained, and the chance of as "
                "much without the effect."},
               {"effect", "value", "doubt"}, rows);
}

Json story_section(const Source& source) {
  const char* title = "Where simulation and measurement part, and why";
  const auto diagnosis = source.jobs.find("diagnose");
  if (diagnosis == source.jobs.end() || source.report.story.empty()) {
    return nullptr;
  }
  const Json details = Json::parse(diagnosis->second.data.result_json).at("details");
  std::vector<std::string> words;
  Json items = Json::array();
  std::size_t number = 0;
  int n_fitted = 0;
  for (const StoryRound& round : source.report.story) {
    const std::string before =
        n_fitted == 0 ? "" : fmt::format(", beside the {} of the round before", n_fitted);
    for (const PointsOf& p : round.fitted) n_fitted += p.n;
    std::string named;
    for (const EffectRow& e : round.effects) named += (named.empty() ? "" : " + ") + e.name;
    words.push_back(fmt::format("Round {} (job {}): {}; named {}; fitted {}{}.", ++number,
                                round.job_id, round.verdict, named.empty() ? "nothing" : named,
                                points_words(round.fitted), before));
    items.push_back(waterfall(source, round, number));
  }
  if (const Json* notes = find(details, "notes")) {
    for (const Json& note : *notes) words.push_back(note.get<std::string>());
  }
  const StoryRound& last = source.report.story.back();
  items.push_back(rivals_table(last));
  items.push_back(audit_table(details));
  items.push_back(next_points(source, diagnosis->second, details));
  return section("story", title, items, words);
}

}  // namespace trammel::report
