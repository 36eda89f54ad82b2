#include "app/report/assess/assessment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "app/files/budget_json.hpp"
#include "app/job/fitted_range.hpp"
#include "app/job/run.hpp"
#include "app/report/job_uncertainty.hpp"
#include "app/report/methods.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/text.hpp"
#include "core/judge/deviation.hpp"
#include "core/judge/floor.hpp"
#include "core/judge/range.hpp"
#include "core/judge/verdict.hpp"
#include "core/measure/noise.hpp"
#include "core/units.hpp"

namespace trammel::assess {

namespace {

struct Noise {
  std::optional<NoiseLevel> level;
  std::string words;
  int coordinates = 2;  // of the place, that are measured

  [[nodiscard]] std::optional<TrackerSigma> sigma() const {
    return level ? std::optional(level->sigma) : std::nullopt;
  }
  [[nodiscard]] std::string verdict(const Summary& position_mm) const {
    if (!level) return "";
    return floor_verdict(position_mm.mean, position_mm.n, level->sigma.xy_mm,
                         level->degrees_of_freedom, coordinates);
  }
};

Noise noise_of(const Campaign& campaign) {
  try {
    const NoiseLevel level = noise_level(campaign);
    return {level, level.words, measured_places(campaign.machine)};
  } catch (const InputError& error) {
    return {std::nullopt, error.text().what + " (" + error.text().got + "): no floor, no verdict",
            measured_places(campaign.machine)};
  }
}

Session assessed(const report::Walk& walk, const Machine& machine, const Noise& noise) {
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
                  .compensation = walk.session.compensation_name,
                  .position_mm = summarise(position),
                  .attitude_rad = machine.measured[2] ? summarise(attitude) : Summary{},
                  .poses = iso9283(readings, noise.sigma()),
                  .rails = iso230(machine, readings, noise.sigma()),
                  .drive = std::string(machine.kind->chain->drive_word),
                  .verdict = {}};
  std::erase_if(session.poses.symbols, [&](const IsoSymbol& s) {  // of what is not measured
    return (!machine.measured[0] && s.name == "AP_x") ||
           (!machine.measured[1] && s.name == "AP_y") ||
           (!machine.measured[2] && s.name.ends_with("_c"));
  });
  session.verdict = noise.verdict(session.position_mm);
  return session;
}

/// One set of points: readings before, poses after.
struct Pairs {
  Judged judged;  // all but the points' figures
  std::vector<const Reading*> before;
  std::vector<Pose> after;
  std::vector<std::string> outside;  // of each point why it is out of range; "" within

  [[nodiscard]] std::vector<Pose> errors() const {
    std::vector<Pose> all;
    for (std::size_t k = 0; k < after.size(); ++k) {
      all.push_back(Pose::from(pose_difference(after[k], before[k]->target)));
    }
    return all;
  }
};

std::vector<Pairs> stored_pairs(const report::Measured& measured, const store::Job& job,
                                const std::vector<report::Group>& groups,
                                const FittedRange& range) {
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
        pairs.outside.push_back(range.why_outside(pair.before->reading.target));
      }
      all.push_back(std::move(pairs));
    }
  }
  return all;
}

Pairs cross_validated_pairs(const report::JobUncertainty& job) {
  Pairs pairs;
  pairs.judged.session = fmt::format("{} spatial blocks", job.cross_validated->blocks);
  pairs.judged.set = "identify";
  pairs.judged.predicted = pairs.judged.cross_validated = true;
  pairs.after = job.cross_validated->after;
  pairs.outside = job.cross_validated->outside;
  for (const Reading& r : job.fitted) pairs.before.push_back(&r);
  return pairs;
}

/// Share of the coordinates of place that lie within U (k = 2) and the reading's noise; nothing
/// without a point in range.
std::optional<double> covered_pct(const Pairs& pairs, const Coordinates& measured,
                                  double sigma_mm) {
  int covered = 0, all = 0;
  const std::vector<Pose> errors = pairs.errors();
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const auto& U = pairs.judged.points[k].U;
    if (!U) continue;
    const double limit = 2 * std::hypot(U->U_mm / 2, sigma_mm);
    const std::array<double, 2> e = {errors[k].x_mm, errors[k].y_mm};
    for (std::size_t c = 0; c < e.size(); ++c) {
      if (!measured[c]) continue;
      ++all;
      covered += std::abs(e[c]) <= limit ? 1 : 0;
    }
  }
  if (all == 0) return std::nullopt;
  return 100.0 * covered / all;
}

void judge(Pairs& pairs, const std::optional<PointUncertainty>& uncertainty, const Noise& noise) {
  std::vector<BeforeAfter> points;
  for (std::size_t k = 0; k < pairs.before.size(); ++k) {
    const Reading& r = *pairs.before[k];
    points.push_back({r.target, *r.measured, pairs.after[k]});
  }
  const Errors errors = errors_in(Figure::position_mm, points);
  for (std::size_t k = 0; k < pairs.before.size(); ++k) {
    const Reading& r = *pairs.before[k];
    Point point{.seq = r.seq,
                .target = r.target,
                .before_mm = errors.before[k],
                .after_mm = errors.after[k],
                .why_no_U = pairs.outside[k]};
    if (pairs.judged.standing == Standing::unknown_epoch) {
      point.why_no_U = "measured in an epoch that the fit knows nothing of";
    } else if (!uncertainty) {
      point.why_no_U = "neither the correction nor a held-out point in range tells it";
    }
    if (point.why_no_U.empty()) point.U = uncertainty->of(r);
    pairs.judged.points.push_back(std::move(point));
  }
  Judged& j = pairs.judged;
  j.before_mm = errors.summary_before;
  j.after_mm = errors.summary_after;
  if (j.standing == Standing::unknown_epoch) return;
  j.improvement_pct = errors.improvement_pct;
  j.improvement_95_pct = improvement_interval_pct(errors.before, errors.after);
  j.verdict = noise.verdict(j.after_mm);
}

void warn(const Pairs& pairs, const FittedRange& range, std::vector<std::string>& warnings) {
  const Judged& j = pairs.judged;
  if (j.standing == Standing::unknown_epoch) {
    std::set<int> epochs;
    for (const Reading* r : pairs.before) epochs.insert(r->conditions.epoch);
    warnings.push_back(fmt::format("{} of {} ({}) {}",
                                   terminal::counted(pairs.before.size(), "point"), j.session,
                                   j.set, job::new_epoch_words({epochs.begin(), epochs.end()})));
  }
  std::vector<Pose> targets;
  for (const Reading* r : pairs.before) targets.push_back(r->target);
  std::ranges::move(job::extrapolation_words(range, targets, "point",
                                             fmt::format(" of {} ({})", j.session, j.set)),
                    std::back_inserter(warnings));
}

/// The budget; and what of it U and the intervals of the improvement lack.
void add_budget(JobAssessment& out, const Campaign& campaign, const NoiseLevel& noise,
                std::optional<double> model_u_mm) {
  out.budget = budget_of(campaign, budget_facts(campaign), noise, model_u_mm);
  const double beside_mm = combined_mm(out.budget, false);
  for (Judged& j : out.sets) {
    std::vector<double> before, after;
    for (Point& p : j.points) {
      if (p.U) p.U->U_mm = std::hypot(p.U->U_mm, 2 * beside_mm);
      before.push_back(p.before_mm);
      after.push_back(p.after_mm);
    }
    if (!j.improvement_95_pct) continue;
    j.improvement_95_pct = improvement_interval_pct(
        before, after, relative_u(out.budget, j.before_mm.mean, j.after_mm.mean, j.predicted));
  }
}

JobAssessment assessed_job(store::Connection& connection, const store::CampaignRow& campaign,
                           const report::Measured& measured, const std::string& session,
                           const store::Job& job, const Noise& noise) {
  if (job.data.campaign_id != campaign.id) {
    throw InputError(
        {.what = "the job is of another campaign",
         .got = fmt::format("job {}", job.id),
         .expected = "a job of " + campaign.name,
         .hint = "see `trammel job list " + terminal::shell_word(campaign.name) + "`"});
  }
  std::vector<report::Group> groups = report::baseline_groups(measured);
  std::erase_if(groups, [&session](const report::Group& g) {
    return !session.empty() && g.walk->session.name != session;
  });
  const report::JobUncertainty known =
      report::uncertainty_of(connection, measured, job, noise.level);
  const std::optional<PointUncertainty>& uncertainty = known.of;
  std::vector<Pairs> all = stored_pairs(measured, job, groups, known.range);
  JobAssessment out;
  out.id = job.id;
  out.stage = job.data.stage;
  if (known.cross_validated) all.push_back(cross_validated_pairs(known));
  if (!known.why_not_validated.empty()) {
    out.warnings.push_back("nothing is held out, and cross-validation could not run: " +
                           known.why_not_validated);
  }
  if (uncertainty) out.uncertainty_from = uncertainty->basis;
  for (Pairs& pairs : all) {
    judge(pairs, uncertainty, noise);
    if (pairs.judged.standing == Standing::unseen && noise.level) {
      pairs.judged.covered_pct =
          covered_pct(pairs, measured.campaign.machine.measured, noise.level->sigma.xy_mm);
      pairs.judged.n_covered = static_cast<std::size_t>(std::ranges::count_if(
          pairs.judged.points, [](const Point& point) { return point.U.has_value(); }));
    }
    warn(pairs, known.range, out.warnings);
    out.sets.push_back(std::move(pairs.judged));
  }
  if (noise.level) add_budget(out, measured.campaign, *noise.level, known.rms_mm);
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
  if (noise.level)
    out.floor_mean_mm = perfect_mean_mm(measured.campaign.machine, noise.level->sigma.xy_mm);
  std::string known;
  for (const report::Walk& walk : measured.walks) {
    known += (known.empty() ? "" : ", ") + walk.session.name;
    if (!session.empty() && walk.session.name != session) continue;
    if (walk.visits.empty()) continue;
    out.sessions.push_back(assessed(walk, measured.campaign.machine, noise));
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
    out.job =
        assessed_job(connection, campaign, measured, session, job::find(connection, job), noise);
  }
  return out;
}

}  // namespace trammel::assess
