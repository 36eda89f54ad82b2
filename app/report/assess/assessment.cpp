#include "app/report/assess/assessment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "app/files/budget_json.hpp"
#include "app/job/fitted_range.hpp"
#include "app/job/held_out.hpp"
#include "app/job/run.hpp"
#include "app/report/methods.hpp"
#include "app/terminal/counted.hpp"
#include "core/calibrate/uncertainty.hpp"
#include "core/judge/deviation.hpp"
#include "core/judge/floor.hpp"
#include "core/judge/range.hpp"
#include "core/judge/verdict.hpp"
#include "core/measure/noise.hpp"
#include "core/plane/blocks.hpp"
#include "core/units.hpp"

namespace trammel::assess {

namespace {

constexpr int kBlocks = 6;

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
  const std::vector<int> block = spatial_blocks(places, kBlocks);
  pairs.after = job::held_out_poses(fit, campaign, fitted, block);
  std::vector<FittedRange> others;  // what each block was predicted from
  for (int b = 0; b < kBlocks; ++b) {
    std::vector<Reading> rest;
    for (std::size_t k = 0; k < fitted.size(); ++k) {
      if (block[k] != b) rest.push_back(fitted[k]);
    }
    others.push_back(fitted_range(rest));
  }
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    pairs.before.push_back(&fitted[k]);
    pairs.outside.push_back(
        others[static_cast<std::size_t>(block[k])].why_outside(fitted[k].target));
  }
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
  std::ranges::move(
      job::extrapolation_words(range, targets, fmt::format("points of {} ({})", j.session, j.set)),
      std::back_inserter(warnings));
}

/// The held-out errors of all sets, within range, and where they come from.
std::string whence(const std::vector<Pairs>& all, std::vector<HeldOut>& held_out) {
  std::string names;
  for (const Pairs& p : all) {
    if (p.judged.standing != Standing::unseen) continue;
    const std::vector<Pose> own = p.errors();
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (p.outside[k].empty()) held_out.push_back({p.before[k], own[k]});
    }
    names += (names.empty() ? "" : ", ") + p.judged.session;
  }
  return "held-out points in range (" + names + ")";
}

/// Of the points with U: the root mean square of their standard uncertainty.
std::optional<double> model_u_mm(const std::vector<Judged>& sets) {
  double squares = 0;
  int n = 0;
  for (const Judged& j : sets) {
    for (const Point& p : j.points) {
      if (!p.U) continue;
      squares += p.U->U_mm * p.U->U_mm / 4;
      ++n;
    }
  }
  if (n == 0) return std::nullopt;
  return std::sqrt(squares / n);
}

/// The budget; and what of it U and the intervals of the improvement lack.
void add_budget(JobAssessment& out, const Campaign& campaign, const NoiseLevel& noise) {
  out.budget = budget_of(campaign, budget_facts(campaign), noise, model_u_mm(out.sets));
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

/// What the correction knows of itself, widened by what held-out points show beyond it; else by
/// these alone; nothing where there are too few of them, or no sigma.
std::optional<PointUncertainty> uncertainty_of(const Correction& correction, const Machine& machine,
                                               const std::vector<Reading>& fitted,
                                               const std::vector<Pairs>& all, const Noise& noise) {
  if (!noise.level) return std::nullopt;
  const TrackerSigma& sigma = noise.level->sigma;
  std::vector<HeldOut> held_out;
  const std::string from = whence(all, held_out);
  for (HeldOut& h : held_out) h.measured = machine.measured;
  if (const auto own = own_uncertainty(correction, machine, fitted, sigma)) {
    return calibrated(*own, held_out, sigma);
  }
  if (held_out.size() < kFewestHeldOut) return std::nullopt;
  return held_out_uncertainty(held_out, from, sigma);
}

JobAssessment assessed_job(store::Connection& connection, const store::CampaignRow& campaign,
                           const report::Measured& measured, const std::string& session,
                           const store::Job& job, const Noise& noise) {
  if (job.data.campaign_id != campaign.id) {
    throw InputError({.what = "the job is of another campaign",
                      .got = fmt::format("job {}", job.id),
                      .expected = "a job of " + campaign.name,
                      .hint = "trammel job list " + campaign.name});
  }
  const Campaign trained = job::trained_on(connection, job);
  const std::vector<Reading> fitted = job::identify_rows(trained);
  std::vector<report::Group> groups = report::baseline_groups(measured);
  std::erase_if(groups, [&session](const report::Group& g) {
    return !session.empty() && g.walk->session.name != session;
  });
  const FittedRange range = fitted_range(fitted);
  std::vector<Pairs> all = stored_pairs(measured, job, groups, range);
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
  const std::optional<PointUncertainty> uncertainty = uncertainty_of(
      job::correction_of(job.data.result_json), measured.campaign.machine, fitted, all, noise);
  if (uncertainty) out.uncertainty_from = uncertainty->basis;
  for (Pairs& pairs : all) {
    judge(pairs, uncertainty, noise);
    if (pairs.judged.standing == Standing::unseen && noise.level) {
      pairs.judged.covered_pct =
          covered_pct(pairs, measured.campaign.machine.measured, noise.level->sigma.xy_mm);
    }
    warn(pairs, range, out.warnings);
    out.sets.push_back(std::move(pairs.judged));
  }
  if (noise.level) add_budget(out, measured.campaign, *noise.level);
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
