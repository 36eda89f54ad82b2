#include "core/diagnose/diagnose.hpp"

#include <algorithm>
#include <cmath>

#include "core/diagnose/gap.hpp"
#include "core/diagnose/noise_floor.hpp"
#include "core/diagnose/verdict.hpp"
#include "core/error.hpp"

namespace trammel {

namespace {

constexpr double kOneLength = 1.1;  // longest approach over the shortest

void require_enough(const Work& w) {
  const auto parameters = base_parameters(w.campaign.machine, w.readings).size();
  const auto coordinates = static_cast<std::size_t>(measured_by(nominal_model(w.campaign.machine)));
  if (coordinates * w.readings.size() >= parameters + 9) return;
  throw InputError({.what = "too few readings to look for a missing effect",
                    .got = std::to_string(w.readings.size()) + " identify readings",
                    .expected = "at least " +
                                std::to_string((parameters + 9 + coordinates - 1) / coordinates) +
                                " for " + std::to_string(parameters) + " parameters of the base",
                    .hint = "measure more points; 'calibrate geometry' fits what there is"});
}

void require_resolved(const DiagnoseOptions& options) {
  const int needed = fewest_replicates(options.false_alarm, options.inadequate);
  if (options.replicates >= needed) return;
  throw InputError(
      {.what = "too few replicates for the level that a test must reach",
       .where = {.field = "replicates"},
       .got = std::to_string(options.replicates),
       .expected = "at least " + std::to_string(needed) +
                   ": the smallest p of n replicates is 1 / (n + 1), above the level otherwise",
       .hint = "the default of 2000 is enough for all levels down to 0.0005"});
}

void say_what_is_not_testable(Work& w) {
  for (const AuditRow& row : w.out.audit) {
    if (!row.missing.empty()) {
      w.out.notes.push_back(row.effect + " can't be tested on these readings: it needs " +
                            row.missing);
    }
  }
  double shortest = INFINITY, longest = 0;
  for (const Reading& r : w.readings) {
    const Displacements moves = r.conditions.cmd_mm - r.conditions.from_mm;
    for (const double move : moves) {
      if (move == 0) continue;
      shortest = std::min(shortest, std::abs(move));
      longest = std::max(longest, std::abs(move));
    }
  }
  if (longest > 0 && longest < kOneLength * shortest) {
    w.one_length_mm = longest;
    w.out.notes.emplace_back(
        "all approaches have one length: on these readings backlash and a memory of the last move "
        "are the same data; approaches of different lengths tell them apart");
  }
}

}  // namespace

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::nothing_missing:
      return "nothing_missing";
    case Verdict::explained:
      return "explained";
    case Verdict::ambiguous:
      return "ambiguous";
    case Verdict::unexplained:
      return "unexplained";
  }
  return {};
}

std::string to_string(NoiseSource source) {
  switch (source) {
    case NoiseSource::tracker:
      return "tracker";
    case NoiseSource::repeats:
      return "repeats";
    case NoiseSource::residuals:
      return "residuals";
  }
  return {};
}

int fewest_replicates(double false_alarm, double inadequate) {
  return static_cast<int>(std::ceil(1 / std::min(false_alarm, inadequate))) - 1;
}

Campaign with_full_records(Campaign campaign) {
  const auto keep_recorded = [&](std::optional<double> Conditions::*cell) {
    const auto lacks = [cell](const Reading& r) {
      return r.measured && !(r.conditions.*cell).has_value();
    };
    const auto without = std::ranges::count_if(campaign.readings, lacks);
    const auto measured =
        std::ranges::count_if(campaign.readings, [](const Reading& r) { return !!r.measured; });
    if (2 * without <= measured) std::erase_if(campaign.readings, lacks);
  };
  keep_recorded(&Conditions::temp_degc);
  keep_recorded(&Conditions::time_s);
  return campaign;
}

Diagnosis diagnose(const Campaign& measured, const DiagnoseOptions& options) {
  const Campaign campaign = with_full_records(measured);
  Work w{
      .campaign = campaign, .options = options, .readings = of_set(campaign, ReadingSet::identify)};
  require_resolved(options);
  require_enough(w);
  first_noise(w);
  const std::vector<Suspicion> found = screened(measured);
  for (const Suspicion& s : found) {
    if (rule_of(s.kind).gravity == Gravity::gross) {
      w.out.suspect.push_back(s);
    } else {
      w.out.notes.push_back(in_words(s));
    }
  }
  if (!w.out.suspect.empty()) {
    leave_to_the_screen(w);
    return w.out;
  }
  drop_certain_readings(w, found);
  fit_base(w);
  settle_tails(w);
  drop_bad_readings(w);
  settle_noise(w);
  settle_correlation(w);
  make_shapes(w, w.space);
  w.out.audit = audit_design(w.space);
  say_what_is_not_testable(w);
  std::vector<Tie> ties;
  decide(w, ties);
  if (ties.empty()) ties = blind_ties(w.out.audit, w.out.fit.model);
  w.out.next =
      plan_next_points(w.base, w.readings, w.out.noise.sigma(), ties,
                       {.new_epoch = options.new_epoch_next, .within = options.next_within});
  measure_gap(campaign, w.readings, w.base, w.out);
  w.out.by_target = reversals_by_target(campaign.machine, w.readings);
  const bool open = w.out.verdict == Verdict::unexplained || w.out.verdict == Verdict::ambiguous;
  if (open && campaign.machine.kind->n_chains == 1) {
    for (const AtTarget& at : w.out.by_target) {
      w.out.notes.push_back(in_words(at, campaign.machine));
    }
  }
  for (const Reading& r : of_set(campaign, ReadingSet::predict)) {
    const PredictedPose p = predict_with_covariance(w.out.fit, r.conditions);
    w.out.predictions.push_back({r.seq, p.pose, p.covariance.diagonal().cwiseSqrt()});
  }
  return w.out;
}

}  // namespace trammel
