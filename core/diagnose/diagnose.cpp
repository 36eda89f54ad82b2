#include "core/diagnose/diagnose.hpp"

#include <algorithm>
#include <cmath>

#include "core/diagnose/gap.hpp"
#include "core/diagnose/look_alikes.hpp"
#include "core/diagnose/noise.hpp"
#include "core/diagnose/selection.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kAssumedXyMm = 0.010;  // where neither tracker nor repeats say: only a first guess
constexpr double kAssumedPhiRad = rad_from_deg(0.01);
constexpr int kEnoughRepeats = 8;  // degrees of freedom before repeats give the noise alone
constexpr double kOtherNoise =
    3.3;  // standard uncertainties (0.1 %) by which a stated sigma must be off

struct Work {
  const Campaign& campaign;
  const DiagnoseOptions& options;
  Diagnosis out = {};
  std::vector<Reading> readings;  // identify, without the bad ones
  GeometryFit base = {};
  ResidualSpace space = {};        // around the base
  std::vector<Shape> shapes = {};  // dictionary and catalogue
  Library library = {};
  bool agreement_taken = false;  // agreement of successive readings was taken for noise
};

std::vector<Reading> of_set(const Campaign& campaign, ReadingSet set) {
  std::vector<Reading> readings;
  for (const Reading& r : campaign.readings) {
    if (r.set == set && (r.measured || set == ReadingSet::predict)) readings.push_back(r);
  }
  return readings;
}

void require_enough(const Work& w) {
  const auto parameters = base_parameters(w.readings).size();
  if (3 * w.readings.size() >= parameters + 9) return;
  throw InputError({.what = "too few readings to look for a missing effect",
                    .got = std::to_string(w.readings.size()) + " identify readings",
                    .expected = "at least " + std::to_string((parameters + 9 + 2) / 3) + " for " +
                                std::to_string(parameters) + " parameters of the base",
                    .hint = "measure more points, or use 'calibrate lsq'"});
}

void fit_base(Work& w) {
  const NoiseFloor& noise = w.out.noise;
  w.base = fit_geometry(nominal_model(w.campaign.mechanism), w.readings, noise.used,
                        {.correlation = noise.correlation});
  w.space = residual_space(w.base, w.readings, noise.used, noise.correlation);
  w.library = make_library(w.space);
}

/// Step 1: whose word on the noise is taken first.
void first_noise(Work& w) {
  NoiseFloor& noise = w.out.noise;
  noise.repeats = pooled_noise(w.readings);
  if (w.campaign.tracker) {
    noise.stated = noise.used = *w.campaign.tracker;
    noise.source = NoiseSource::tracker;
  } else if (noise.repeats && noise.repeats->degrees_of_freedom >= kEnoughRepeats) {
    noise.used = noise.repeats->sigma;
    noise.source = NoiseSource::repeats;
  } else {
    noise.used = {kAssumedXyMm, kAssumedPhiRad};
    noise.source = NoiseSource::residuals;
    w.out.notes.push_back(
        "no sigma is stated and there are too few repeats: the noise is what base and catalogue "
        "leave, so structure "
        "that looks like noise can't be seen");
  }
}

/// White residuals of another size than was stated are not structure: scale, and go on.
void settle_noise(Work& w) {
  for (int round = 0; round < 3; ++round) {
    const NoiseRatio ratio = noise_ratio(w.space, w.library.signals);
    const bool unknown = w.out.noise.source == NoiseSource::residuals;
    const bool xy = unknown || std::abs(ratio.xy - 1) > kOtherNoise * ratio.u_xy;
    const bool phi = unknown || std::abs(ratio.phi - 1) > kOtherNoise * ratio.u_phi;
    if (!xy && !phi) return;
    if (xy) w.out.noise.used.xy_mm *= ratio.xy;
    if (phi) w.out.noise.used.phi_rad *= ratio.phi;
    w.out.noise.rescaled = !unknown;
    fit_base(w);
  }
}

/// Noise that is correlated in time is still noise: successive readings are made independent.
void settle_correlation(Work& w, bool known = false) {
  const auto space_with = [&](double rho) {
    return residual_space(
        fit_geometry(w.base.model, w.readings, w.out.noise.used, {.correlation = rho}), w.readings,
        w.out.noise.used, rho);
  };
  w.out.noise.correlation = noise_correlation(space_with, known);
  if (w.out.noise.correlation == 0) return;
  w.out.notes.push_back(
      "the noise of successive readings is correlated: it is taken out before anything is tested");
  fit_base(w);
}

/// Single bad readings first: four outliers must not become seven effects.
void drop_bad_readings(Work& w) {
  NamedEffect bad;
  bad.name = "outlier_readings";
  for (int round = 0; round < 5; ++round) {
    const auto places = bad_readings(w.space, w.library.signals);
    if (places.empty()) break;
    for (auto it = places.rbegin(); it != places.rend(); ++it) {
      bad.seqs.push_back(w.readings[*it].seq);
      w.readings.erase(w.readings.begin() + static_cast<std::ptrdiff_t>(*it));
    }
    fit_base(w);
  }
  if (bad.seqs.empty()) return;
  std::sort(bad.seqs.begin(), bad.seqs.end());
  bad.p = kFalseOutlier;
  w.out.effects.push_back(std::move(bad));
}

void make_shapes(Work& w, const ResidualSpace& space) {
  w.shapes = dictionary(space);
  for (const Unit& unit : w.library.units) {
    const Effect& effect = effect_catalogue()[static_cast<std::size_t>(unit.effect)];
    Shape shape{"effect " + effect.name, "all", {}};
    shape.columns.resize(space.rows(), static_cast<Eigen::Index>(unit.columns.size()));
    for (std::size_t c = 0; c < unit.columns.size(); ++c) {
      shape.columns.col(static_cast<Eigen::Index>(c)) = w.library.signals.col(unit.columns[c]);
    }
    w.shapes.push_back(std::move(shape));
  }
}

StructureTest test(const Work& w, const ResidualSpace& space, double level) {
  return test_structure(space, w.shapes,
                        {w.options.replicates, level, w.options.seed, w.options.threads});
}

/// The base with the candidate's effects, fitted on the exact model.
GeometryFit fit_with(const Work& w, const Candidate& candidate) {
  RobotModel start = w.base.model;
  Eigen::Index at = 0;
  for (const int u : candidate.units) {
    const Unit& unit = w.library.units[static_cast<std::size_t>(u)];
    const Effect* effect = &effect_catalogue()[static_cast<std::size_t>(unit.effect)];
    if (start.effects.empty() || start.effects.back().effect != effect) {
      start.effects.push_back(
          {effect, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(effect->parameters.size()))});
    }
    for (const int k : unit.parameters) {
      const double v = candidate.values[at++];
      start.effects.back().values[k] = v != 0 ? v : 1e-12;
    }
  }
  return fit_geometry(start, w.readings, w.out.noise.used,
                      {.correlation = w.out.noise.correlation});
}

void name_effects(Work& w, const Candidate& best, const GeometryFit& fit) {
  for (std::size_t e = 0; e < fit.model.effects.size(); ++e) {
    const ActiveEffect& active = fit.model.effects[e];
    NamedEffect named;
    named.name = active.effect->name;
    for (std::size_t j = 0; j < fit.parameters.size(); ++j) {
      const FreeParameter& p = fit.parameters[j];
      if (p.kind != FreeParameter::Kind::effect || p.owner != static_cast<int>(e)) continue;
      const EffectParameter& about = active.effect->parameters[static_cast<std::size_t>(p.index)];
      const auto jj = static_cast<Eigen::Index>(j);
      const double value = active.values[p.index];
      const double std = p.scale * std::sqrt(fit.covariance(jj, jj));
      named.parameters.push_back(
          {about.name, about.unit, value, std,
           value > about.usual_max + 2 * std || value < about.low() - 2 * std});
      if (about.rail >= 0 && (named.rails.empty() || named.rails.back() != about.rail + 1)) {
        named.rails.push_back(about.rail + 1);
      }
    }
    std::vector<int> others;
    for (const int u : best.units) {
      if (effect_catalogue()[static_cast<std::size_t>(
                                 w.library.units[static_cast<std::size_t>(u)].effect)]
              .name != named.name) {
        others.push_back(u);
      }
    }
    const double drop = best.gain - gain_of(w.library, others);
    named.share_of_gap = best.gain > 0 ? drop / best.gain : 0;
    named.p = chi2_tail(drop, static_cast<double>(named.parameters.size()));
    w.out.effects.push_back(std::move(named));
  }
}

void say_what_is_not_testable(Work& w) {
  for (const AuditRow& row : w.out.audit) {
    if (!row.missing.empty()) {
      w.out.notes.push_back(row.effect + " can't be tested on these readings: it needs " +
                            row.missing);
    }
  }
}

/// The shape without a name that a finding speaks of; none for an effect's, or for neighbours.
const Shape* shape_of(const Work& w, const Finding& finding) {
  const auto at = std::find_if(w.shapes.begin(), w.shapes.end(), [&](const Shape& s) {
    return s.where == finding.where && s.when == finding.when && !s.terms.empty();
  });
  return at == w.shapes.end() ? nullptr : &*at;
}

/// Abstains: what the catalogue could do is told as tried, and is not added to the model.
void leave_unexplained(Work& w, std::vector<Finding> where) {
  Diagnosis& out = w.out;
  out.verdict = Verdict::unexplained;
  out.structure = std::move(where);
  const auto tried =
      std::stable_partition(out.effects.begin(), out.effects.end(),
                            [](const NamedEffect& e) { return e.name == "outlier_readings"; });
  out.tried.assign(tried, out.effects.end());
  out.effects.erase(tried, out.effects.end());
  out.fit = w.base;
  NoiseFloor& noise = out.noise;
  const TrackerSigma& first =
      noise.source == NoiseSource::repeats ? noise.repeats->sigma : noise.stated;
  if (noise.rescaled && noise.used.xy_mm > first.xy_mm) {
    // the structure is part of that size: it says nothing about the noise
    noise.used = first;
    noise.rescaled = false;
    out.notes.push_back(
        "the residuals are larger than the noise that tracker or repeats state, but structure is "
        "in "
        "them: the floor shown is the stated one");
  }
  out.notes.push_back(
      "a map can take out part of what is unexplained without saying what it is: calibrate hybrid, "
      "as a generic correction");
}

/// What the findings have most of, as a tie that points may show again.
void add_unexplained_tie(const Work& w, const Candidate& tried, std::vector<Tie>& ties) {
  for (const Finding& finding : w.out.structure) {
    const Shape* shape = shape_of(w, finding);
    if (shape == nullptr) continue;
    ties.push_back(tie_of_unexplained(w.space, w.library, tried, *shape));
    return;
  }
}

/// Successive readings agreeing is what stands out most, more than any shape: that is noise
/// correlated in time as well, and is made independent (once). True when it was, and all must be
/// tested anew.
bool took_agreement_for_noise(Work& w, const StructureTest& t, double level) {
  const bool agree =
      t.family_p <= level && !t.findings.empty() && t.findings.front().when == kSuccessiveAgree;
  if (!agree || w.agreement_taken) return false;
  w.agreement_taken = true;
  const double before = w.out.noise.correlation;
  settle_correlation(w, true);
  make_shapes(w, w.space);
  return w.out.noise.correlation != before;
}

/// The best set, and what else was looked at.
struct Naming {
  Candidate best;
  std::vector<Candidate> all;
  std::optional<Finding> unnamed;  // shape that does best in place of an effect
  double unnamed_score = 0;
  std::optional<LookAlike> alike;
};

/// Why the named set can't stand: what it leaves, or what explains more; nothing when it can.
std::vector<Finding> objections(const Work& w, const Naming& naming) {
  if (w.out.after.family_p <= w.options.inadequate) return w.out.after.findings;
  if (naming.unnamed && naming.unnamed_score > naming.best.score + kEvidence20To1)
    return {*naming.unnamed};
  if (naming.alike && naming.alike->evidence > 2 * kEvidence20To1) return {naming.alike->finding};
  return {};
}

void add_unnamed_rival(Work& w, const Finding& finding, double lead) {
  w.out.rivals.push_back({{"unnamed: " + finding.where + ", " + finding.when},
                          finding.terms,
                          std::exp(0.5 * lead),
                          false});
}

/// Everything that explains the readings as well, each with the tie that points may break.
void add_rivals(Work& w, const Naming& naming, std::vector<Tie>& ties) {
  Diagnosis& out = w.out;
  const Candidate& best = naming.best;
  for (const Candidate& c : rivals_of(best, naming.all)) {
    const double lead = best.score - c.score;
    out.rivals.push_back({names_of(c), c.parameters, std::exp(0.5 * lead), false});
    ties.push_back(tie_between(w.library, best, c, lead));
  }
  for (const Candidate& c : structural_ties(w.library, best)) {
    const bool known = std::any_of(out.rivals.begin(), out.rivals.end(), [&](Rival& r) {
      r.structural = r.structural || r.names == names_of(c);
      return r.names == names_of(c);
    });
    if (known) continue;
    out.rivals.push_back({names_of(c), c.parameters, 1, true});
    ties.push_back(tie_between(w.library, best, c, 0));
  }
  if (naming.unnamed && naming.unnamed_score > best.score - kEvidence20To1) {
    const double lead = best.score - naming.unnamed_score;
    add_unnamed_rival(w, *naming.unnamed, lead);
    if (const Shape* shape = shape_of(w, *naming.unnamed))
      ties.push_back(tie_with_unnamed(w.space, w.library, best, *shape, lead));
  }
  if (naming.alike) add_unnamed_rival(w, naming.alike->finding, -naming.alike->evidence);
}

void decide(Work& w, std::vector<Tie>& ties) {
  Diagnosis& out = w.out;
  out.before = test(w, w.space, w.options.false_alarm);
  if (took_agreement_for_noise(w, out.before, w.options.false_alarm))
    out.before = test(w, w.space, w.options.false_alarm);
  out.fit = w.base;
  if (out.before.family_p > w.options.false_alarm) {
    out.verdict = out.effects.empty() ? Verdict::nothing_missing : Verdict::explained;
    return;
  }
  Naming naming;
  naming.all = search(w.library, 3);
  if (naming.all.empty() || naming.all.front().score <= 0) {
    leave_unexplained(w, out.before.findings);
    add_unexplained_tie(w, {}, ties);
    return;
  }
  naming.best = extend(w.library, naming.all.front());
  const Candidate fitted = with_all_rails(w.library, naming.best);
  out.fit = fit_with(w, fitted);
  const ResidualSpace left =
      residual_space(out.fit, w.readings, out.noise.used, out.noise.correlation);
  out.after = test(w, left, w.options.inadequate);
  if (took_agreement_for_noise(w, out.after, w.options.inadequate)) return decide(w, ties);
  name_effects(w, fitted, out.fit);
  naming.unnamed = best_unnamed(w.space, w.library, naming.best, w.shapes, naming.unnamed_score);
  naming.alike = best_look_alike(w.space, w.library, naming.best);
  if (const auto findings = objections(w, naming); !findings.empty()) {
    leave_unexplained(w, findings);
    add_unexplained_tie(w, naming.best, ties);
    return;
  }
  add_rivals(w, naming, ties);
  out.considered = runners_up(naming.best, naming.all);
  out.verdict = out.rivals.empty() ? Verdict::explained : Verdict::ambiguous;
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

Diagnosis diagnose(const Campaign& campaign, const DiagnoseOptions& options) {
  Work w{
      .campaign = campaign, .options = options, .readings = of_set(campaign, ReadingSet::identify)};
  require_enough(w);
  first_noise(w);
  fit_base(w);
  drop_bad_readings(w);
  settle_noise(w);
  settle_correlation(w);
  make_shapes(w, w.space);
  w.out.audit = audit_design(w.space);
  say_what_is_not_testable(w);
  std::vector<Tie> ties;
  decide(w, ties);
  if (ties.empty()) ties = blind_ties(w.out.audit, w.out.fit.model);
  w.out.next = plan_next_points(w.base, w.readings, w.out.noise.used, ties,
                                {.new_epoch = options.new_epoch_next});
  measure_gap(campaign, w.readings, w.base, w.out);
  for (const Reading& r : of_set(campaign, ReadingSet::predict)) {
    const PredictedPose p = predict_with_covariance(w.out.fit, r.conditions);
    w.out.predictions.push_back({r.seq, p.pose, p.covariance.diagonal().cwiseSqrt()});
  }
  return w.out;
}

}  // namespace trammel
