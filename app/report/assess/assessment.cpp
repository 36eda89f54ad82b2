#include "app/report/assess/assessment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "app/job/held_out.hpp"
#include "app/job/run.hpp"
#include "app/report/assess/uncertainty.hpp"
#include "app/report/methods.hpp"
#include "core/judge/deviation.hpp"
#include "core/judge/verdict.hpp"
#include "core/measure/noise.hpp"
#include "core/plane/blocks.hpp"
#include "core/plane/hull.hpp"
#include "core/units.hpp"

namespace trammel::assess {

namespace {

constexpr int kBlocks = 6;
constexpr double kPhiSlackRad = rad_from_deg(0.05);

struct Noise {
  std::optional<TrackerSigma> sigma;
  std::string words;
};

Noise noise_of(const Campaign& campaign) {
  try {
    const NoiseLevel level = noise_level(campaign);
    return {level.sigma, level.words};
  } catch (const InputError& error) {
    return {std::nullopt, error.text().what + " (" + error.text().got + "): no floor, no verdict"};
  }
}

std::string verdict(double mean_mm, const std::optional<double>& floor_mm) {
  return floor_mm ? floor_verdict(mean_mm, *floor_mm) : "";
}

Session assessed(const report::Walk& walk, const Mechanism& mechanism, const Noise& noise,
                 const std::optional<double>& floor_mm) {
  std::vector<Reading> readings;
  std::vector<double> position, attitude;
  for (const Visit& visit : walk.visits) {
    const Reading& r = visit.reading;
    readings.push_back(r);
    position.push_back(position_error_mm(*r.measured, r.target));
    attitude.push_back(attitude_error_rad(*r.measured, r.target));
  }
  Session session{.name = walk.session.name,
                  .plan = walk.session.plan_name,
                  .compensation_job = walk.session.compensation_job,
                  .position_mm = summarise(position),
                  .attitude_rad = summarise(attitude),
                  .poses = iso9283(readings, noise.sigma),
                  .rails = iso230(mechanism, readings, noise.sigma),
                  .verdict = {}};
  session.verdict = verdict(session.position_mm.mean, floor_mm);
  return session;
}

/// Where the readings that a job fitted lie.
struct Range {
  std::vector<Place> hull;
  double phi_low = 0, phi_high = 0;

  [[nodiscard]] bool holds_place(const Pose& p) const { return inside(hull, {p.x_mm, p.y_mm}); }
  [[nodiscard]] bool holds_phi(const Pose& p) const {
    return p.phi_rad >= phi_low - kPhiSlackRad && p.phi_rad <= phi_high + kPhiSlackRad;
  }
};

Range range_of(const std::vector<Reading>& fitted) {
  std::vector<Place> places;
  Range range{{}, fitted.front().target.phi_rad, fitted.front().target.phi_rad};
  for (const Reading& r : fitted) {
    places.push_back({r.target.x_mm, r.target.y_mm});
    range.phi_low = std::min(range.phi_low, r.target.phi_rad);
    range.phi_high = std::max(range.phi_high, r.target.phi_rad);
  }
  range.hull = convex_hull(places);
  return range;
}

/// One set of points: readings before, poses after.
struct Pairs {
  Judged judged;  // all but the points' figures
  std::vector<const Reading*> before;
  std::vector<Pose> after;

  [[nodiscard]] std::vector<Pose> errors() const {
    std::vector<Pose> all;
    for (std::size_t k = 0; k < after.size(); ++k) {
      all.push_back(Pose::from(pose_difference(after[k], before[k]->target)));
    }
    return all;
  }
};

std::vector<Pairs> stored_pairs(const report::Measured& measured, const store::Job& job,
                                const std::vector<report::Group>& groups) {
  std::vector<Pairs> all;
  const Seen seen = report::seen_by(measured, job);
  for (const report::Group& group : groups) {
    for (const report::Comparison& c : report::judged(measured, group, job, seen)) {
      Pairs pairs;
      Judged& judged = pairs.judged;
      judged.session = group.walk->session.name;
      judged.set = group.circles                       ? "circles"
                   : group.set == ReadingSet::identify ? "identify"
                                                       : "validate";
      judged.standing = c.standing;
      judged.predicted = c.paired.predicted;
      for (const report::Pair& pair : c.paired.pairs) {
        pairs.before.push_back(&pair.before->reading);
        pairs.after.push_back(pair.after);
      }
      all.push_back(std::move(pairs));
    }
  }
  return all;
}

/// The fitted readings, each under a correction that never saw its block.
Pairs cross_validated(const store::Job& job, const Campaign& campaign,
                      const std::vector<Reading>& fitted) {
  std::vector<Place> places;
  for (const Reading& r : fitted) places.push_back({r.target.x_mm, r.target.y_mm});
  const job::Stage& stage = job::find_stage(job.data.stage);
  const job::Json parameters = job::completed(stage, job::Json::parse(job.data.parameters_json));
  const auto fit = [&](const Campaign& training) {
    return stage.run(job::as_asked(training, parameters), parameters).correction;
  };
  Pairs pairs;
  pairs.judged.session = fmt::format("{} spatial blocks", kBlocks);
  pairs.judged.set = "identify";
  pairs.judged.predicted = pairs.judged.cross_validated = true;
  pairs.after = job::held_out_poses(fit, campaign, fitted, spatial_blocks(places, kBlocks));
  for (const Reading& r : fitted) pairs.before.push_back(&r);
  return pairs;
}

/// Share of the coordinates of place that lie within U (k = 2) and the reading's noise, where that
/// noise is not in U already.
double covered_pct(const Pairs& pairs, double sigma_mm) {
  int covered = 0;
  const std::vector<Pose> errors = pairs.errors();
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const double limit = 2 * std::hypot(pairs.judged.points[k].U_mm / 2, sigma_mm);
    for (const double e : {errors[k].x_mm, errors[k].y_mm}) covered += std::abs(e) <= limit ? 1 : 0;
  }
  return 100.0 * covered / static_cast<double>(2 * errors.size());
}

void judge(Pairs& pairs, const PointUncertainty& uncertainty, const Range& range,
           const std::optional<double>& floor_mm) {
  std::vector<BeforeAfter> points;
  for (std::size_t k = 0; k < pairs.before.size(); ++k) {
    const Reading& r = *pairs.before[k];
    points.push_back({r.target, *r.measured, pairs.after[k]});
  }
  const Errors errors = errors_in(Figure::position_mm, points);
  for (std::size_t k = 0; k < pairs.before.size(); ++k) {
    const Reading& r = *pairs.before[k];
    const Expanded U = uncertainty.of(r);
    pairs.judged.points.push_back(
        {.seq = r.seq,
         .target = r.target,
         .before_mm = errors.before[k],
         .after_mm = errors.after[k],
         .U_mm = U.U_mm,
         .U_rad = U.U_rad,
         .outside = !range.holds_place(r.target) || !range.holds_phi(r.target)});
  }
  Judged& j = pairs.judged;
  j.before_mm = errors.summary_before;
  j.after_mm = errors.summary_after;
  if (j.standing == Standing::unknown_epoch) return;
  j.improvement_pct = errors.improvement_pct;
  j.improvement_95_pct = improvement_interval_pct(errors.before, errors.after);
  j.verdict = verdict(j.after_mm.mean, floor_mm);
}

void warn(const Pairs& pairs, const Range& range, std::vector<std::string>& warnings) {
  int place = 0, phi = 0;
  for (const Reading* r : pairs.before) {
    place += range.holds_place(r->target) ? 0 : 1;
    phi += range.holds_phi(r->target) ? 0 : 1;
  }
  const Judged& j = pairs.judged;
  if (j.standing == Standing::unknown_epoch) {
    std::set<int> epochs;
    for (const Reading* r : pairs.before) epochs.insert(r->conditions.epoch);
    warnings.push_back(fmt::format("{} points of {} ({}) {}", pairs.before.size(), j.session, j.set,
                                   job::new_epoch_words({epochs.begin(), epochs.end()})));
  }
  if (place > 0) {
    warnings.push_back(fmt::format(
        "{} of {} points of {} ({}) lie outside the convex hull of the measured points: there the "
        "correction extrapolates",
        place, pairs.before.size(), j.session, j.set));
  }
  if (phi > 0) {
    warnings.push_back(fmt::format(
        "{} of {} points of {} ({}) are turned beyond the measured orientations ({:.2f} to {:.2f} "
        "deg): there the correction extrapolates",
        phi, pairs.before.size(), j.session, j.set, deg_from_rad(range.phi_low),
        deg_from_rad(range.phi_high)));
  }
}

/// The held-out errors of all sets, their readings, and where they come from.
std::string whence(const std::vector<Pairs>& all, std::vector<Pose>& errors,
                   std::vector<const Reading*>& readings) {
  std::string names;
  for (const Pairs& p : all) {
    if (p.judged.standing != Standing::unseen) continue;
    const std::vector<Pose> own = p.errors();
    errors.insert(errors.end(), own.begin(), own.end());
    readings.insert(readings.end(), p.before.begin(), p.before.end());
    names += (names.empty() ? "" : ", ") + p.judged.session;
  }
  return "held-out points (" + names + ")";
}

JobAssessment assessed_job(store::Connection& connection, const store::CampaignRow& campaign,
                           const report::Measured& measured, const std::string& session,
                           const store::Job& job, const Noise& noise,
                           const std::optional<double>& floor_mm) {
  if (job.data.campaign_id != campaign.id) {
    throw InputError({.what = "the job is of another campaign",
                      .got = fmt::format("job {}", job.id),
                      .expected = "a job of " + campaign.name,
                      .hint = "trammel job list " + campaign.name});
  }
  const Campaign trained =
      store::load_campaign(connection, campaign.id, {.sessions = job.data.sessions}).campaign;
  const std::vector<Reading> fitted = job::identify_rows(trained);
  std::vector<report::Group> groups = report::baseline_groups(measured);
  std::erase_if(groups, [&session](const report::Group& g) {
    return !session.empty() && g.walk->session.name != session;
  });
  std::vector<Pairs> all = stored_pairs(measured, job, groups);
  const bool any_held_out = std::ranges::any_of(
      all, [](const Pairs& p) { return p.judged.standing == Standing::unseen; });
  JobAssessment out;
  out.id = job.id;
  out.stage = job.data.stage;
  if (!any_held_out) {
    try {
      all.push_back(cross_validated(job, trained, fitted));
    } catch (const InputError& error) {
      out.warnings.push_back("nothing is held out, and cross-validation could not run: " +
                             error.text().what);
    }
  }
  const Range range = range_of(fitted);
  const Correction correction = job::correction_of(job.data.result_json);
  std::optional<PointUncertainty> uncertainty;
  double beside_mm = 0;  // noise of a reading that U leaves out
  if (noise.sigma) {
    uncertainty = own_uncertainty(correction, measured.campaign.mechanism, fitted, *noise.sigma);
  }
  std::vector<Pose> errors;
  std::vector<const Reading*> held_out;
  const std::string from = whence(all, errors, held_out);
  if (uncertainty) beside_mm = noise.sigma->xy_mm;
  if (uncertainty && !errors.empty()) {
    uncertainty = widened(*uncertainty, held_out, errors, *noise.sigma);
  }
  if (!uncertainty) {
    if (errors.empty()) {
      throw InputError({.what = "nothing is known of the uncertainty of this job's correction",
                        .expected = "held-out points, or enough readings to cross-validate"});
    }
    uncertainty = held_out_uncertainty(errors, from);
  }
  out.uncertainty_from = uncertainty->basis;
  for (Pairs& pairs : all) {
    judge(pairs, *uncertainty, range, floor_mm);
    if (pairs.judged.standing == Standing::unseen)
      pairs.judged.covered_pct = covered_pct(pairs, beside_mm);
    warn(pairs, range, out.warnings);
    out.sets.push_back(std::move(pairs.judged));
  }
  return out;
}

}  // namespace

Assessment gather(store::Connection& connection, const store::CampaignRow& campaign,
                  const std::string& session, const std::string& job) {
  const report::Measured measured = report::load_measured(connection, campaign);
  const Noise noise = noise_of(measured.campaign);
  Assessment out;
  out.campaign = campaign.name;
  out.simulated = campaign.simulated;
  out.noise = noise.words;
  if (noise.sigma) out.floor_mean_mm = noise_floor_mean_mm(noise.sigma->xy_mm);
  std::string known;
  for (const report::Walk& walk : measured.walks) {
    known += (known.empty() ? "" : ", ") + walk.session.name;
    if (!session.empty() && walk.session.name != session) continue;
    if (walk.visits.empty()) continue;
    out.sessions.push_back(assessed(walk, measured.campaign.mechanism, noise, out.floor_mean_mm));
  }
  if (out.sessions.empty() && !session.empty()) {
    throw NotFoundError({.what = "the campaign has no such session with measured readings",
                         .got = session,
                         .expected = known.empty() ? "none is stored" : known});
  }
  if (out.sessions.empty()) {
    throw InputError({.what = "there is nothing to assess",
                      .got = campaign.name + " without a measured reading",
                      .hint = "measure a session, or import readings"});
  }
  if (!job.empty()) {
    out.job = assessed_job(connection, campaign, measured, session, job::find(connection, job),
                           noise, out.floor_mean_mm);
  }
  return out;
}

}  // namespace trammel::assess
