#include "app/report/story.hpp"

#include <algorithm>

#include "app/report/from_job.hpp"
#include "app/report/measured.hpp"

namespace trammel::report {

namespace {

using Json = nlohmann::ordered_json;

std::string joined(const Json& names) {
  std::string text;
  for (const Json& name : names) text += (text.empty() ? "" : " + ") + name.get<std::string>();
  return text;
}

EffectRow effect_row(const Json& effect) {
  EffectRow row{.name = effect.at("name"),
                .p = effect.value("p", 0.0),
                .share_of_gap = effect.value("share_of_gap", 0.0)};
  for (const Json& p : effect.at("parameters")) {
    row.values.push_back({p.at("name"), p.at("unit"), p.at("value"), p.at("std")});
  }
  if (effect.contains("seq")) row.seqs = effect.at("seq").get<std::vector<int>>();
  return row;
}

bool within(const std::vector<store::Id>& some, const std::vector<store::Id>& all) {
  return std::all_of(some.begin(), some.end(), [&all](store::Id id) {
    return std::find(all.begin(), all.end(), id) != all.end();
  });
}

/// Counts the readings of each session that the job used, by what they were used for.
void add_points(StoryRound& round, const Measured& measured, const store::Job& job,
                const std::vector<store::Id>& known) {
  const Seen seen = seen_by(measured, job);
  for (const Walk& walk : measured.walks) {
    if (!within({walk.session.id}, job.data.sessions)) continue;
    const auto n_identify =
        static_cast<int>(std::count_if(walk.visits.begin(), walk.visits.end(), [](const Visit& v) {
          return v.reading.set == ReadingSet::identify;
        }));
    const auto n_validate =
        static_cast<int>(std::count_if(walk.visits.begin(), walk.visits.end(), [&](const Visit& v) {
          return v.reading.set == ReadingSet::validate &&
                 seen.standing(v.reading) == Standing::unseen;
        }));
    if (n_identify > 0 && !within({walk.session.id}, known)) {
      round.fitted.push_back({walk.session.name, n_identify});
    }
    if (n_validate > 0) round.judged.push_back({walk.session.name, n_validate});
  }
}

}  // namespace

StoryRound round_of(const store::Job& job) {
  const Json details = Json::parse(job.data.result_json).at("details");
  StoryRound round{.job_id = job.id,
                   .job_key = job.data.key.key,
                   .verdict = details.at("verdict"),
                   .noise_floor_mm = details.at("noise_floor_mm"),
                   .n_next_points = static_cast<int>(details.at("next_points").size())};
  for (const Json& p : details.at("next_points")) {
    const std::string why = p.at("why");
    if (std::ranges::find(round.next_why, why) == round.next_why.end())
      round.next_why.push_back(why);
  }
  for (const Json& effect : details.at("effects")) round.effects.push_back(effect_row(effect));
  if (details.contains("tried")) {
    for (const Json& effect : details.at("tried")) round.tried.push_back(effect.at("name"));
  }
  if (details.contains("rival_odds")) {
    for (const Json& r : details.at("rival_odds")) {
      round.rivals.push_back({joined(r.at("names")), r.at("odds"), r.at("structural")});
    }
  }
  for (const Json& e : details.value("may_also_hold", Json::array())) {
    round.may_also_hold.emplace_back(e.at("name"), e.at("probability"));
  }
  for (const char* chain : {"gap", "gap_tried"}) {  // the second only where something was tried
    for (const Json& g : details.value(chain, Json::array())) {
      round.gap.push_back({g.at("model"), optional_number(g.at("identify_rms_mm")),
                           optional_number(g.at("validate_rms_mm")), chain != std::string("gap")});
    }
  }
  return round;
}

std::vector<StoryRound> story_of(store::Connection& connection, const Measured& measured,
                                 const store::Job& last) {
  std::vector<StoryRound> story;
  std::vector<store::Id> known;  // sessions of the round before
  for (const store::JobRow& row : store::list_jobs(connection, last.data.campaign_id)) {
    if (row.stage != last.data.stage || row.id > last.id) continue;
    const store::Job job = store::get_job(connection, row.id);
    const bool repeated = std::any_of(story.begin(), story.end(), [&job](const StoryRound& r) {
      return r.job_key == job.data.key.key;
    });
    if (repeated || job.data.parameters_json != last.data.parameters_json ||
        !within(job.data.sessions, last.data.sessions)) {
      continue;
    }
    if (!why_not_shown(job).empty()) continue;
    story.push_back(round_of(job));
    add_points(story.back(), measured, job, known);
    known = job.data.sessions;
  }
  return story;
}

Json story_json(const std::vector<StoryRound>& story) {
  const auto points_json = [](const std::vector<PointsOf>& points) {
    Json all = Json::array();
    for (const PointsOf& p : points) all.push_back({{"session", p.session}, {"n", p.n}});
    return all;
  };
  const auto number = [](const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); };
  Json rounds = Json::array();
  for (const StoryRound& r : story) {
    Json effects = Json::array(), rivals = Json::array(), gap = Json::array();
    for (const EffectRow& e : r.effects) {
      Json values = Json::array();
      for (const EffectRow::Value& v : e.values) {
        values.push_back({{"name", v.name}, {"value", v.value}, {"std", v.std}, {"unit", v.unit}});
      }
      effects.push_back({{"name", e.name}, {"parameters", values}});
      if (!e.seqs.empty()) effects.back()["seq"] = e.seqs;
    }
    for (const RivalRow& v : r.rivals) {
      rivals.push_back({{"names", v.names}, {"odds", v.odds}, {"structural", v.structural}});
    }
    for (const GapRow& g : r.gap) {
      gap.push_back({{"model", g.model},
                     {"identify_rms_mm", number(g.identify_rms_mm)},
                     {"validate_rms_mm", number(g.validate_rms_mm)}});
      if (g.tried) gap.back()["tried"] = true;
    }
    rounds.push_back({{"job", r.job_id},
                      {"job_key", r.job_key},
                      {"verdict", r.verdict},
                      {"new_fitted", points_json(r.fitted)},
                      {"judged_on", points_json(r.judged)},
                      {"effects", effects},
                      {"tried", r.tried},
                      {"rivals", rivals},
                      {"gap", gap},
                      {"noise_floor_mm", r.noise_floor_mm},
                      {"n_next_points", r.n_next_points},
                      {"next_why", r.next_why}});
  }
  return rounds;
}

}  // namespace trammel::report
