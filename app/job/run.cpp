#include "app/job/run.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <set>

#include <fmt/format.h>

#include "app/job/fitted_range.hpp"
#include "app/job/points.hpp"
#include "app/job/screening.hpp"
#include "app/job/walks.hpp"
#include "core/judge/before_after.hpp"
#include "core/judge/deviation.hpp"
#include "core/judge/seen.hpp"
#include "core/measure/bad_readings.hpp"
#include "core/statistics/interval.hpp"
#include "core/statistics/summary.hpp"
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

/// A reading before, and as predicted after the correction.
struct Judged {
  int seq = 0;
  ReadingSet set = ReadingSet::identify;
  int epoch = 0;
  Standing standing = Standing::unseen;
  BeforeAfter point;
};

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

/// Every measured reading of the walks that stand, with its place in the judgement.
std::vector<Judged> judge(const Inputs& in, const Seen& seen, const Correction& correction) {
  const Campaign& campaign = in.loaded.campaign;
  std::vector<Reading> measured;
  measured.reserve(campaign.readings.size());
  const NominalMachine machine(campaign.machine);
  const bool goes_on = in.stage->name == "diagnose";  // it names what can't be, and leaves it out
  for (const Reading& r : campaign.readings) {
    if (r.measured && (!goes_on || machine.chains(*r.measured).ok())) measured.push_back(r);
  }
  const auto all_after = predicted_after(correction, campaign.machine, measured);
  std::vector<Judged> points;
  points.reserve(measured.size());
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const Reading& r = measured[k];
    if (!all_after[k]) {
      throw InputError({.what = "the corrected robot cannot reach a target of the campaign",
                        .where = {.point = "seq " + std::to_string(r.seq)}});
    }
    if (in.of_no_walk.contains(r.seq)) continue;
    points.push_back({.seq = r.seq,
                      .set = r.set,
                      .epoch = r.conditions.epoch,
                      .standing = seen.standing(r),
                      .point = {r.target, machine.measured_else(*r.measured, r.target),
                                machine.measured_else(*all_after[k], r.target)}});
  }
  return points;
}

std::vector<BeforeAfter> points_of(const std::vector<Judged>& judged, Standing standing) {
  std::vector<BeforeAfter> points;
  for (const Judged& j : judged) {
    if (j.standing == standing) points.push_back(j.point);
  }
  return points;
}

constexpr Standing kStandings[] = {Standing::fitted, Standing::unseen, Standing::unknown_epoch};

const char* set_of(Standing standing) {
  switch (standing) {
    case Standing::fitted:
      return "identify";
    case Standing::unseen:
      return "validate";
    case Standing::unknown_epoch:
      return kNewEpoch;
  }
  return "";
}

store::Summary stored(const Summary& s) {
  return {.mean = s.mean, .max = s.max, .min = s.min, .p95 = s.p95, .n = static_cast<int>(s.n)};
}

std::vector<store::Statistic> statistics(const Machine& machine,
                                         const std::vector<Judged>& judged) {
  std::vector<store::Statistic> all;
  for (const Standing standing : kStandings) {
    const std::vector<BeforeAfter> points = points_of(judged, standing);
    if (points.empty()) continue;
    for (const Figure figure : figures_of(machine)) {
      const Errors errors = errors_in(figure, points);
      all.push_back({set_of(standing),
                     figure == Figure::position_mm ? "position_mm" : "attitude_deg",
                     standing == Standing::fitted, stored(errors.summary_before),
                     stored(errors.summary_after)});
    }
  }
  return all;
}

/// Interval of each improvement.
Json improvements(const std::vector<Judged>& judged) {
  Json all = Json::array();
  for (const Standing standing : {Standing::fitted, Standing::unseen}) {
    const std::vector<BeforeAfter> points = points_of(judged, standing);
    if (points.empty()) continue;
    const Errors errors = errors_in(Figure::position_mm, points);
    const auto interval = improvement_interval_pct(errors.before, errors.after);
    if (!interval) continue;
    all.push_back(object_with("set", set_of(standing), "metric", "position_mm", "in_sample",
                              standing == Standing::fitted, "improvement_low_pct", interval->low,
                              "improvement_high_pct", interval->high));
  }
  return all;
}

std::vector<std::string> improvement_words(const Json& improvements) {
  std::vector<std::string> words;
  for (const Json& row : improvements) {
    words.push_back(fmt::format(
        "{} position: 95 % interval of the gain {:.1f} to {:.1f} % (t of the log ratio); `trammel "
        "assess --job` gives U",
        row["in_sample"].get<bool>() ? "in-sample" : "held-out",
        row["improvement_low_pct"].get<double>(), row["improvement_high_pct"].get<double>()));
  }
  return words;
}

/// A warning where the correction is judged beyond the points it was fitted to.
std::vector<std::string> range_words(const std::vector<Judged>& judged) {
  std::vector<Reading> fitted;
  std::vector<Pose> held_out;
  for (const Judged& j : judged) {
    if (j.standing == Standing::fitted) fitted.emplace_back().target = j.point.target;
    if (j.standing == Standing::unseen) held_out.push_back(j.point.target);
  }
  if (fitted.empty()) return {};
  std::vector<std::string> words =
      extrapolation_words(trammel::fitted_range(fitted), held_out, "held-out points");
  for (std::string& sentence : words) sentence = "warning: " + sentence;
  return words;
}

/// Where validation points stand on fitted ones or in epochs of their own, and where nothing is
/// held out.
std::vector<std::string> held_out_words(const Inputs& in, const std::vector<Judged>& judged) {
  int all = 0, unseen = 0, fitted = 0;
  std::set<int> epochs;
  for (const Judged& j : judged) {
    if (j.set != ReadingSet::validate) continue;
    ++all;
    unseen += j.standing == Standing::unseen ? 1 : 0;
    fitted += j.standing == Standing::fitted ? 1 : 0;
    if (j.standing == Standing::unknown_epoch) epochs.insert(j.epoch);
  }
  std::vector<std::string> words;
  if (!in.of_no_walk.empty()) {
    words.push_back(fmt::format(
        "{} readings of walks that were stopped and walked anew are fitted, but judge nothing",
        in.of_no_walk.size()));
  }
  if (fitted > 0) {
    words.push_back(fmt::format(
        "warning: {} of {} validation points stand where the correction was fitted: they are not "
        "held out, and count as in-sample",
        fitted, all));
  }
  if (!epochs.empty()) {
    words.push_back(fmt::format("warning: {} of {} validation points {}", all - unseen - fitted,
                                all, new_epoch_words({epochs.begin(), epochs.end()})));
  }
  if (unseen == 0) {
    words.push_back(
        "nothing of these readings is held out: in-sample figures do not say how good the "
        "correction "
        "is elsewhere; "
        "`trammel assess --job` cross-validates over spatial blocks");
  }
  return words;
}

/// Readings of a set that are wrong for certain.
std::vector<Suspicion> suspects_of(const Campaign& campaign,
                                   ReadingSet set = ReadingSet::identify) {
  std::vector<Suspicion> bad = bad_readings(campaign);
  std::erase_if(bad, [&](const Suspicion& s) {
    return std::ranges::none_of(campaign.readings, [&](const Reading& r) {
      return r.seq == s.seqs.front() && r.set == set;
    });
  });
  return bad;
}

/// "in-sample 12.3 %, held-out -702.0 %": gains of the mean position error.
std::string gains_in_words(const std::vector<Judged>& judged) {
  std::string text;
  for (const Standing standing : {Standing::fitted, Standing::unseen}) {
    const std::vector<BeforeAfter> points = points_of(judged, standing);
    if (points.empty()) continue;
    const Errors e = errors_in(Figure::position_mm, points);
    text += fmt::format("{}{} {:.4f} -> {:.4f} mm", text.empty() ? "" : ", ",
                        standing == Standing::fitted ? "in-sample" : "held-out",
                        e.summary_before.mean, e.summary_after.mean);
  }
  return text;
}

/// The figures with the suspects in the fit, and how they would be without.
std::vector<std::string> suspect_words(const Inputs& in, const Seen& seen,
                                       const std::vector<Judged>& judged, Json& details) {
  constexpr std::size_t kNamed = 5;
  if (in.stage->name == "diagnose") return {};  // it leaves them out, and says so
  std::vector<std::string> words;
  const auto name = [&](const std::vector<Suspicion>& some, const char* what) {
    for (std::size_t k = 0; k < std::min(some.size(), kNamed); ++k)
      words.push_back(fmt::format("warning: {}: {}", what, in_words(some[k])));
    if (some.size() > kNamed)
      words.push_back(fmt::format("warning: and {} suspect readings more", some.size() - kNamed));
  };
  name(suspects_of(in.loaded.campaign, ReadingSet::validate),
       "suspect reading, which judges the correction all the same");
  const std::vector<Suspicion> bad = suspects_of(in.loaded.campaign);
  if (bad.empty()) return words;
  details["suspect_readings"] = findings_json(bad);
  name(bad, "suspect reading");
  try {
    Inputs without = in;
    std::erase_if(without.loaded.campaign.readings, [&](const Reading& r) {
      return std::ranges::any_of(bad, [&](const Suspicion& s) { return s.seqs.front() == r.seq; });
    });
    const StageResult result = in.stage->run(with_judges(without, seen), in.parameters);
    words.push_back(fmt::format("with {} suspect reading{} in the fit: {}; without: {}", bad.size(),
                                bad.size() == 1 ? "" : "s", gains_in_words(judged),
                                gains_in_words(judge(without, seen, result.correction))));
  } catch (const InputError& error) {
    words.push_back(std::string("without the suspect readings nothing is fitted: ") + error.what());
  }
  return words;
}

/// A fit that fails over a reading which is wrong for certain names it.
std::pair<StageResult, std::vector<Judged>> fitted_and_judged(const Inputs& in, const Seen& seen) {
  try {
    StageResult result = in.stage->run(with_judges(in, seen), in.parameters);
    std::vector<Judged> judged = judge(in, seen, result.correction);
    return {std::move(result), std::move(judged)};
  } catch (const InputError& error) {
    const std::vector<Suspicion> bad = suspects_of(in.loaded.campaign);
    if (bad.empty()) throw;
    ErrorText text = error.text();
    text.what += "; suspect reading: " + in_words(bad.front());
    text.hint = "--without-suspects calibrates without it";
    throw InputError(text);
  }
}

/// Nothing is calibrated on what the screen finds gross, unless asked for.
void require_sound(const Inputs& in, const Request& request) {
  if (in.stage->name == "diagnose" || request.despite_screen) return;
  trammel::require_sound(in.loaded.campaign, screened(in.loaded.campaign),
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
        range_words(judged), held_out_words(in, judged)}) {
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

std::string new_epoch_words(const std::vector<int>& epochs) {
  std::string numbers;
  for (const int epoch : epochs) numbers += (numbers.empty() ? "" : ", ") + std::to_string(epoch);
  return fmt::format(
      "were measured in epoch {}, of which no reading was fitted: how far homing and frame moved "
      "there is not known, so they do not judge the correction. Identify from readings of that "
      "epoch as well, or resume with reference points",
      numbers);
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
