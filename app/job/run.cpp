#include "app/job/run.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <set>

#include <fmt/format.h>

#include "app/job/judged.hpp"
#include "app/job/points.hpp"
#include "app/job/screening.hpp"
#include "app/job/walks.hpp"
#include "core/judge/deviation.hpp"
#include "core/judge/seen.hpp"
#include "core/measure/bad_readings.hpp"
#include "core/measure/held_epochs.hpp"
#include "core/units.hpp"
#include "store/session.hpp"
#include "store/transaction.hpp"

namespace trammel::job {

namespace {

struct Inputs {
  const Stage* stage = nullptr;
  Json parameters;
  store::Id campaign = 0;
  store::LoadedCampaign loaded;
  int n_readings = 0;  // suspects too
  HeldEpochs held;
  std::set<int> of_no_walk = {};  // seqs that judge nothing
  store::JobKey key;
};

std::vector<store::Id> chosen_sessions(store::Connection& connection, store::Id campaign_id,
                                       const std::vector<std::string>& names) {
  std::vector<store::Id> ids;
  std::string known;
  const auto sessions = store::session_names(connection, campaign_id);
  for (const store::SessionName& s : sessions) {
    known += (known.empty() ? "" : ", ") + s.name;
    if (names.empty() && !s.compensated && !s.references) ids.push_back(s.id);
  }
  for (const std::string& name : names) {
    const auto at = std::ranges::find(sessions, name, &store::SessionName::name);
    if (at == sessions.end()) {
      throw NotFoundError({.what = "the campaign has no such session",
                           .got = name,
                           .expected = known.empty() ? "none is stored" : known});
    }
    ids.push_back(at->id);
  }
  if (ids.empty()) {
    throw InputError({.what = "the campaign has no baseline session to calibrate from",
                      .got = known.empty() ? "no session" : "sessions " + known,
                      .expected = "a session measured without compensation",
                      .hint = "measure one, or name sessions with --session"});
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

/// Of all readings of its sessions those that the job saw: more have higher seqs.
void go_back_to(store::LoadedCampaign& loaded, const store::NewJob& then) {
  std::erase_if(loaded.exclusions, [&](const store::Exclusion& e) {
    return std::ranges::find(then.exclusions, e.id) == then.exclusions.end();
  });
  std::vector<Reading>& readings = loaded.campaign.readings;
  std::erase_if(readings, [&](const Reading& r) {
    return std::ranges::find(loaded.exclusions, r.seq, &store::Exclusion::seq) !=
           loaded.exclusions.end();
  });
  readings.resize(std::min(readings.size(), static_cast<std::size_t>(then.n_readings)));
}

std::vector<int> excluded_seqs(const store::LoadedCampaign& loaded) {
  std::vector<int> seqs;
  for (const store::Exclusion& e : loaded.exclusions) seqs.push_back(e.seq);
  return seqs;
}

/// The inputs as they are now, or as they were `then`.
Inputs load(store::Connection& connection, const Request& request,
            int key_scheme = store::kKeyScheme, const store::NewJob* then = nullptr) {
  Inputs in;
  in.stage = &find_stage(request.stage);
  in.parameters = completed(*in.stage, request.parameters);
  in.campaign = store::require_campaign_id(connection, request.campaign);
  in.loaded =
      store::load_campaign(connection, in.campaign,
                           {.sessions = chosen_sessions(connection, in.campaign, request.sessions),
                            .with_excluded = then != nullptr});
  if (then != nullptr) go_back_to(in.loaded, *then);
  in.n_readings = static_cast<int>(in.loaded.campaign.readings.size());
  in.loaded.campaign = as_asked(std::move(in.loaded.campaign), in.parameters);
  in.held = store::held_epochs(connection, in.campaign);
  in.of_no_walk = seqs_of_no_walk(connection, in.campaign, in.loaded, then != nullptr);
  in.key = store::job_key({.stage = in.stage->name,
                           .algorithm_version = in.stage->algorithm_version,
                           .parameters_json = in.parameters.dump(),
                           .campaign = in.loaded.campaign,
                           .excluded_seqs = excluded_seqs(in.loaded)},
                          key_scheme);
  return in;
}

/// It names what can't be, and goes on without.
bool leaves_out(const Inputs& in) { return in.stage->name == "diagnose"; }

std::vector<Judged> judged_by(const Seen& seen, const Inputs& in, const Correction& correction) {
  return judge(in.loaded.campaign,
               {.seen = seen, .of_no_walk = in.of_no_walk, .leaves_out = leaves_out(in)},
               correction);
}

/// Less the validation readings that cannot judge a fit: they stand where it is made, in an epoch
/// that it knows nothing of, or in a walk that does not stand.
Campaign with_judges(const Inputs& in, const Seen& seen) {
  Campaign campaign = in.loaded.campaign;
  std::erase_if(campaign.readings, [&](const Reading& r) {
    return r.set == ReadingSet::validate &&
           (seen.standing(r) != Standing::unseen || in.of_no_walk.contains(r.seq));
  });
  return campaign;
}

/// Of each epoch that a fit takes for another: where it may choose, and the set-up held between.
std::map<int, int> one_set_up(const Campaign& campaign, const Json& parameters,
                              const HeldEpochs& held) {
  if (parameters.value("epochs", "") != "auto" || held.empty()) return {};
  return epochs_of_one_set_up(campaign.machine, identify_rows(campaign), held);
}

std::string one_set_up_words(const std::map<int, int>& epochs) {
  std::vector<std::string> some;
  for (const auto& [epoch, first] : epochs) some.push_back(fmt::format("{} as {}", epoch, first));
  return fmt::format("epochs: reference points held, and readings show no step: fitted {}",
                     fmt::join(some, ", "));
}

/// The stage on `campaign`; what it finds of an epoch holds in all of one set-up.
StageResult run_stage(const Inputs& in, Campaign campaign) {
  const std::map<int, int> epochs = one_set_up(campaign, in.parameters, in.held);
  renumber(campaign.readings, epochs);
  StageResult result = in.stage->run(campaign, in.parameters);
  EpochShifts* shifts = epochs_of(result.correction);
  for (const auto& [epoch, first] : epochs) {
    if (shifts == nullptr || !shifts->contains(first)) continue;
    const EpochShift shift = shifts->at(first);
    shifts->insert_or_assign(epoch, shift);
  }
  if (!epochs.empty()) result.words.push_back(one_set_up_words(epochs));
  return result;
}

/// Readings that are wrong for certain: those of a fit, and those that judge it.
struct Suspects {
  std::vector<Suspicion> fitted = {}, judging = {};
};
Suspects suspects_of(const Campaign& campaign) {
  Suspects found;
  for (Suspicion& s : bad_readings(campaign)) {
    const auto at = std::ranges::find(campaign.readings, s.seqs.front(), &Reading::seq);
    if (at == campaign.readings.end()) continue;
    if (at->set == ReadingSet::identify)
      found.fitted.push_back(std::move(s));
    else if (at->set == ReadingSet::validate)
      found.judging.push_back(std::move(s));
  }
  return found;
}

/// The figures with the suspects in the fit, and how they would be without.
std::vector<std::string> suspect_words(const Inputs& in, const Seen& seen,
                                       const std::vector<Judged>& judged, Json& details) {
  constexpr std::size_t kNamed = 5;
  if (leaves_out(in)) return {};
  std::vector<std::string> words;
  const auto name = [&](const std::vector<Suspicion>& some, const char* what) {
    for (std::size_t k = 0; k < std::min(some.size(), kNamed); ++k)
      words.push_back(fmt::format("warning: {}: {}", what, in_words(some[k])));
    if (some.size() > kNamed)
      words.push_back(fmt::format("warning: and {} suspect readings more", some.size() - kNamed));
  };
  const auto [bad, judging] = suspects_of(in.loaded.campaign);
  name(judging, "suspect reading, which judges the correction all the same");
  if (bad.empty()) return words;
  details["suspect_readings"] = findings_json(bad);
  name(bad, "suspect reading");
  try {
    Inputs without = in;
    std::erase_if(without.loaded.campaign.readings, [&bad = bad](const Reading& r) {
      return std::ranges::any_of(bad, [&](const Suspicion& s) { return s.seqs.front() == r.seq; });
    });
    const StageResult result = run_stage(without, with_judges(without, seen));
    words.push_back(fmt::format("with {} suspect reading{} in the fit: {}; without: {}", bad.size(),
                                bad.size() == 1 ? "" : "s", gains_in_words(judged),
                                gains_in_words(judged_by(seen, without, result.correction))));
  } catch (const InputError& error) {
    words.push_back(std::string("without the suspect readings nothing is fitted: ") + error.what());
  }
  return words;
}

/// A fit that fails over a reading which is wrong for certain names it.
std::pair<StageResult, std::vector<Judged>> fitted_and_judged(const Inputs& in, const Seen& seen) {
  try {
    StageResult result = run_stage(in, with_judges(in, seen));
    std::vector<Judged> judged = judged_by(seen, in, result.correction);
    return {std::move(result), std::move(judged)};
  } catch (const InputError& error) {
    const std::vector<Suspicion> bad = suspects_of(in.loaded.campaign).fitted;
    if (bad.empty()) throw;
    ErrorText text = error.text();
    text.what += "; suspect reading: " + in_words(bad.front());
    text.hint = "--without-suspects calibrates without it";
    throw InputError(text);
  }
}

/// Nothing is calibrated on what the screen finds gross, unless asked for.
void require_sound(const Inputs& in, const Request& request) {
  if (leaves_out(in) || request.despite_screen) return;
  trammel::require_sound(in.loaded.campaign, screened(in.loaded.campaign, in.held),
                         "`trammel diagnose` shows it; --despite-screen calibrates all the same");
}

store::NewJob begun(const Inputs& in) {
  store::NewJob job;
  job.campaign_id = in.campaign;
  job.key = in.key;
  job.stage = in.stage->name;
  job.algorithm_version = in.stage->algorithm_version;
  job.parameters_json = in.parameters.dump();
  job.n_readings = in.n_readings;
  job.sessions = in.loaded.sessions;
  for (const store::Exclusion& e : in.loaded.exclusions) job.exclusions.push_back(e.id);
  return job;
}

store::NewJob computed(const Inputs& in) {
  const auto start = std::chrono::steady_clock::now();
  const Seen seen = seen_by_fit(in.loaded.campaign, in.held, is_one_set_up(in.parameters));
  auto [result, judged] = fitted_and_judged(in, seen);
  store::NewJob job = begun(in);
  job.statistics = statistics(in.loaded.campaign.machine, judged);
  const Json gains = improvements(judged);
  std::vector<store::JobPoint> points;
  points.reserve(judged.size());
  for (const Judged& j : judged) {
    points.push_back({.seq = j.seq,
                      .in_sample = j.standing == Standing::fitted,
                      .after = Pose::from(pose_difference(j.point.after, j.point.target))});
  }
  for (const auto& more :
       {suspect_words(in, seen, judged, result.details), improvement_words(gains),
        range_words(judged), held_out_words(judged, in.of_no_walk.size())}) {
    result.words.insert(result.words.end(), more.begin(), more.end());
  }
  job.result_json =
      canonical_object({{"correction", canonical_text(correction_json(result.correction))},
                        {"details", canonical_text(result.details)},
                        {"words", canonical_text(result.words)},
                        {"improvements", canonical_text(gains)},
                        {"after", canonical_text("predicted")},
                        {"points", points_text(points)},
                        {"timing", canonical_text(result.timing)}});
  job.duration_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return job;
}

}  // namespace

bool is_one_set_up(const Json& parameters) { return parameters.value("epochs", "") == "shared"; }

Campaign trained_on(store::Connection& connection, const store::Job& job) {
  const Json parameters = Json::parse(job.data.parameters_json);
  Campaign campaign = as_asked(
      store::load_campaign(connection, job.data.campaign_id, {.sessions = job.data.sessions})
          .campaign,
      parameters);
  renumber(campaign.readings,
           one_set_up(campaign, parameters, store::held_epochs(connection, job.data.campaign_id)));
  return campaign;
}

store::NewJob compute(store::Connection& connection, const Request& request) {
  return computed(load(connection, request));
}

store::NewJob recompute(store::Connection& connection, const store::Job& job) {
  return computed(load(connection, request_of(connection, job), job.data.key.scheme, &job.data));
}

store::JobKey key_today(store::Connection& connection, const store::Job& job) {
  if (job.data.key.scheme == store::kKeyScheme) return job.data.key;
  const Inputs in = load(connection, request_of(connection, job), store::kKeyScheme, &job.data);
  return store::job_key({.stage = job.data.stage,
                         .algorithm_version = job.data.algorithm_version,
                         .parameters_json = job.data.parameters_json,
                         .campaign = in.loaded.campaign,
                         .excluded_seqs = excluded_seqs(in.loaded)});
}

std::optional<Computation> compute_new(store::Connection& connection, const Request& request) {
  Computation computation;
  std::optional<store::Snapshot> snapshot(connection);
  const Inputs in = load(connection, request);
  computation.readings_head = store::chain_head(connection, in.campaign);
  computation.n_exclusions = store::exclusions(connection, in.campaign).size();
  if (!request.force && store::has_job(connection, in.campaign, in.key.key)) return std::nullopt;
  require_sound(in, request);
  snapshot.reset();
  computation.job = computed(in);
  return computation;
}

bool still_holds(store::Connection& connection, const Computation& computation) {
  const store::Id campaign = computation.job.campaign_id;
  return store::chain_head(connection, campaign) == computation.readings_head &&
         store::exclusions(connection, campaign).size() == computation.n_exclusions;
}

store::NewJob inputs_of(store::Connection& connection, const Request& request, int key_scheme) {
  return begun(load(connection, request, key_scheme));
}

store::CampaignRow campaign_of(store::Connection& connection, const store::NewJob& job) {
  if (auto row = store::find_campaign(connection, job.campaign_id)) return *std::move(row);
  throw StoreError({.what = "the job's campaign is not there",
                    .where = {.file = connection.file().string()},
                    .hint = "see `trammel db verify`"});
}

Outcome run(store::Connection& connection, const Request& request) {
  const Inputs in = load(connection, request);
  require_sound(in, request);
  if (!request.force) {
    if (auto known = store::find_job(connection, in.campaign, in.key.key))
      return {*std::move(known), true};
  }
  const store::NewJob job = computed(in);
  if (request.dry_run) {
    return {.job = {.id = 0, .created_utc = {}, .provenance = store::this_program(), .data = job}};
  }
  // Who asks for the same at the same time waits here, and then reuses what the first one stored.
  store::Transaction transaction(connection);
  if (load(connection, request).key.key != in.key.key) {
    throw StoreError({.what = "the readings changed while they were calibrated",
                      .where = {.field = in.loaded.campaign.name},
                      .hint = "run the calibration again when nothing writes to the campaign"});
  }
  if (!request.force) {
    if (auto known = store::find_job(connection, in.campaign, in.key.key))
      return {*std::move(known), true};
  }
  const store::Id id = store::add_job(connection, job);
  transaction.commit();
  return {store::get_job(connection, id), false};
}

bool same_result(const std::string& a, const std::string& b) {
  Json one = Json::parse(store::canonical_json(a, "result"));
  Json other = Json::parse(store::canonical_json(b, "result"));
  one.erase("timing");
  other.erase("timing");
  return one.dump() == other.dump();
}

Correction correction_of(store::Connection& connection, store::Id job_id) {
  return correction_of(store::get_job(connection, job_id).data.result_json);
}

Request request_of(store::Connection& connection, const store::Job& job) {
  Request request{.campaign = campaign_of(connection, job.data).uuid,
                  .stage = job.data.stage,
                  .parameters = Json::parse(job.data.parameters_json),
                  .sessions = {}};
  for (const store::Id id : job.data.sessions) {
    request.sessions.push_back(store::get_session(connection, id).name);
  }
  return request;
}

store::Job find(store::Connection& connection, const std::string& text) {
  std::vector<store::Id> found;
  store::Id id = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), id);
  const bool whole = parsed.ec == std::errc{} && parsed.ptr == text.data() + text.size();
  for (const store::JobRow& row : store::list_jobs(connection)) {
    if (whole && row.id == id) return store::get_job(connection, row.id);
    if (text.size() >= 6 && row.key.starts_with(text)) found.push_back(row.id);
  }
  if (found.empty()) {
    throw NotFoundError({.what = "no such job",
                         .got = text,
                         .expected = "a job's number, or six or more digits of its key",
                         .hint = "trammel job list"});
  }
  return store::get_job(connection, found.back());
}

}  // namespace trammel::job
