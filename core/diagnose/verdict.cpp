#include "core/diagnose/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <utility>

#include "core/diagnose/naming.hpp"
#include "core/diagnose/noise_floor.hpp"
#include "core/diagnose/plausible.hpp"
#include "core/diagnose/unnamed.hpp"
#include "core/model/predictor.hpp"
#include "core/statistics/tail.hpp"

namespace trammel {

namespace {

constexpr double kAdequate = 0.05;  // what named effects leave is white without any doubt

/// The shape without a name that a finding speaks of; none for an effect's, or for neighbours.
const Shape* shape_of(const Work& w, const Finding& finding) {
  const auto at = std::find_if(w.shapes.begin(), w.shapes.end(), [&](const Shape& s) {
    return s.where == finding.where && s.when == finding.when && !s.terms.empty();
  });
  return at == w.shapes.end() ? nullptr : &*at;
}

/// The findings that the correction for all tests leaves; the first at least.
std::vector<Finding> significant(const StructureTest& test, double level) {
  std::vector<Finding> left;
  for (const Finding& f : test.findings) {
    if (left.empty() || f.p * test.tests <= level) left.push_back(f);
  }
  return left;
}

/// Abstains: what the catalogue could do is reported as tried, and is not added to the model.
void leave_unexplained(Work& w, std::vector<Finding> where) {
  Diagnosis& out = w.out;
  out.verdict = Verdict::unexplained;
  out.structure = std::move(where);
  const auto tried =
      std::stable_partition(out.effects.begin(), out.effects.end(),
                            [](const NamedEffect& e) { return e.name == "outlier_readings"; });
  out.tried.assign(tried, out.effects.end());
  out.effects.erase(tried, out.effects.end());
  out.tried_model = out.fit.model;
  out.fit = w.base;
  NoiseFloor& noise = out.noise;
  if (noise.rescaled && noise.used.xy_mm > noise.first.xy_mm) {
    // the structure is part of that size: it says nothing about the noise
    noise.used = noise.first;
    noise.y_over_x = 1;
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
void add_unexplained_tie(const Work& w, const ResidualSpace& space, const Library& library,
                         const Candidate& tried, std::vector<Tie>& ties) {
  for (const Finding& finding : w.out.structure) {
    const Shape* shape = shape_of(w, finding);
    if (shape == nullptr) continue;
    ties.push_back(tie_of_unexplained(space, library, tried, *shape));
    return;
  }
}

/// A course of time as such: a trend, a wave, a step. Noise that is correlated has them too, the
/// more the less of its correlation was taken out.
bool of_time(const Work& w, const Finding& finding) {
  return std::ranges::any_of(time_courses(w.space), [&](const Shape& s) {
    return s.where == finding.where && s.when == finding.when;
  });
}

/// Successive readings agreeing (or alternating) is what stands out most, more than any shape: that
/// is noise correlated in time as well, and is made independent (once). So is what noise that is
/// correlated for certain has of courses in time: its rho was estimated beside them, which leaves
/// (1 - rho')^2 / (1 - rho)^2 of them where it came out low; now they count for it. What happened
/// in fact, a shift, stands out after that as well. True when all must be tested anew.
bool took_agreement_for_noise(Work& w, const StructureTest& t, double level) {
  if (t.family_p > level || t.findings.empty()) return false;
  const Finding& most = t.findings.front();
  const bool agree = most.when == kSuccessiveAgree || most.when == kSuccessiveAlternate ||
                     (w.out.noise.correlation > 0 && of_time(w, most));
  if (!agree || w.agreement_taken) return false;
  w.agreement_taken = true;
  const double before = w.out.noise.correlation;
  settle_correlation(w, true);
  make_shapes(w, w.space);
  return w.out.noise.correlation != before;
}

double chi2_of_unseen(const Work& w, const RobotModel& model) {
  double sum = 0;
  const Predictor expected(model);
  for (const Reading& r : of_set(w.campaign, ReadingSet::validate)) {
    const Prediction at = expected.predict(r.conditions);
    if (!at.ok()) return INFINITY;
    const Eigen::Vector3d d = r.measured->vector() - at.pose.vector();
    sum += d.cwiseQuotient(w.out.noise.sigma().of(model.nominal.measured)).squaredNorm();
  }
  return sum;
}

/// The reversal that stands out most of what `model` leaves at the targets which runs reach from
/// both sides: in runs up and down, one that differs from target to target looks like noise that
/// alternates, and only its place gives it away. Nothing where chance would leave as much in
/// `inadequate` of campaigns (Student's t at each target, times the number of targets).
std::optional<Finding> reversal_left(const Work& w, const RobotModel& model) {
  std::vector<Reading> left;  // target and what the model leaves there
  const Predictor expected(model);
  for (Reading r : w.readings) {
    const Prediction at = expected.predict(r.conditions);
    if (!at.ok()) continue;
    r.measured = Pose::from(r.target.vector() + r.measured->vector() - at.pose.vector());
    left.push_back(std::move(r));
  }
  const std::vector<AtTarget> all = reversals_by_target(w.campaign.machine, left);
  std::optional<Finding> most;
  for (const AtTarget& at : all) {
    const double t = at.reversal_mm / at.reversal_std_mm;
    const double p = student_tail(t, at.readings - 3);
    if (!(p * static_cast<double>(all.size()) <= w.options.inadequate)) continue;
    if (most && most->p <= p) continue;
    char when[160];
    std::snprintf(when, sizeof when,
                  "its reversal differs from target to target: %+.2f +- %.2f um are left at %g mm",
                  1000 * at.reversal_mm, 1000 * at.reversal_std_mm, at.target_mm);
    most = {drive_name(w.campaign.machine, at.chain), when, p, t * t, 1};
  }
  return most;
}

/// Why the named set can't stand: what it leaves, or what explains more; nothing when it can.
std::vector<Finding> objections(const Work& w, const Naming& n) {
  std::vector<Finding> found;
  if (const auto reversal = reversal_left(w, w.out.fit.model)) found.push_back(*reversal);
  if (!n.best.usual) {
    found.push_back({drives_name(*w.space.machine.kind),
                     "named effects need a sign that they can't have (an overshoot is no backlash)",
                     chi2_tail(n.best.gain, n.best.parameters), n.best.gain, n.best.parameters});
  }
  if (const auto unsupported = unsupported_noise(w)) found.push_back(*unsupported);
  if (!found.empty()) return found;
  if (w.out.base.implausible()) {
    return {
        {"the base", in_words(w.out.base), w.out.base.p, w.out.base.chi2, w.out.base.directions}};
  }
  if (w.out.after.family_p <= w.options.inadequate)
    return significant(w.out.after, w.options.inadequate);
  // a shape of many coefficients pays one price, and named effects one each: where what these leave
  // is white without any doubt it is a rival, no objection
  const bool adequate = w.out.after.family_p > kAdequate;
  if (!adequate && n.unnamed && n.unnamed_score > n.best.score + kEvidence20To1)
    return {*n.unnamed};
  for (const LookAlike& alike : n.alike) {
    if (alike.evidence > kEvidence20To1) return {alike.finding};
  }
  const double worse = chi2_of_unseen(w, w.out.fit.model) - chi2_of_unseen(w, w.base.model);
  if (worse > kEvidence20To1)
    return {{"unseen readings", "the named effects make their predictions worse", 1, worse, 0}};
  return {};
}

/// Everything that explains the readings as well, each with the tie that points may break.
void add_rivals(Work& w, const Naming& n, std::vector<Tie>& ties) {
  Diagnosis& out = w.out;
  const Candidate& best = n.best;
  const auto add = [&](const Candidate& c, double lead, bool structural) {
    const auto known = std::ranges::find(out.rivals, names_of(c), &Rival::names);
    if (known != out.rivals.end()) {
      known->structural = known->structural || structural;
      return;
    }
    out.rivals.push_back({names_of(c), c.parameters, std::exp(0.5 * lead), structural});
    ties.push_back(tie_between(n.library, best, c, lead));
  };
  for (const Candidate& c : rivals_of(best, n.all)) add(c, best.score - c.score, false);
  for (const Candidate& c : structural_ties(n.library, best)) add(c, 0, true);
  // a named effect that the average does not hold for sure: the best set without it
  for (const int effect : best.effects) {
    if (n.mean.probability[static_cast<std::size_t>(effect)] >= kSure) continue;
    const auto other = std::ranges::find_if(n.all, [&](const Candidate& c) {
      return c.usual && std::ranges::find(c.effects, effect) == c.effects.end();
    });
    if (other != n.all.end()) add(*other, best.score - other->score, false);
  }
  if (n.unnamed && n.unnamed_score > best.score - kEvidence20To1) {
    const double lead = best.score - n.unnamed_score;
    out.rivals.push_back({{"unnamed: " + n.unnamed->where + ", " + n.unnamed->when},
                          n.unnamed->terms,
                          std::exp(0.5 * lead),
                          false});
    if (const Shape* shape = shape_of(w, *n.unnamed))
      ties.push_back(tie_with_unnamed(n.space, n.library, best, *shape, lead));
  }
  for (const LookAlike& alike : n.alike) {
    out.rivals.push_back(
        {{alike.name}, alike.finding.terms, std::exp(-0.5 * alike.evidence), false});
    ties.push_back(tie_with_look_alike(n.library, best, alike));
    if (alike.name == "plane_tilt")
      out.notes.emplace_back(
          "a tilted measuring plane (plane_tilt) is nearly the same data as a scale: level the "
          "frame, or measure the plane's normal with points of all nests");
  }
}

/// What the average over sets says beside the named ones: other effects, and their other rails.
void add_possible(Work& w, const Naming& n) {
  for (std::size_t e = 0; e < n.mean.probability.size(); ++e) {
    const Effect& effect = effect_catalogue()[e];
    const auto named = std::ranges::find(w.out.effects, effect.name, &NamedEffect::name);
    Possible possible{effect.name, 0};
    for (int k = 0; k < std::ssize(effect.parameters); ++k) {
      const EffectParameter& about = effect.parameters[static_cast<std::size_t>(k)];
      const auto column = column_of(n.library, static_cast<int>(e), k);
      const bool told = named != w.out.effects.end() &&
                        std::ranges::find(named->parameters, about.name, &NamedParameter::name) !=
                            named->parameters.end();
      if (!column || told) continue;
      possible.probability = std::max(possible.probability, n.mean.presence[*column]);
      possible.parameters.push_back({about.name, about.unit, 0, n.std_about(*column, 0)});
    }
    if (named == w.out.effects.end()) possible.probability = n.mean.probability[e];
    if (named == w.out.effects.end() && n.open.probability[e] >= kOpenPossible)
      possible.probability = n.open.probability[e];
    if (possible.probability >= kPossible) w.out.may_also_hold.push_back(std::move(possible));
  }
  std::ranges::stable_sort(w.out.may_also_hold, std::greater{}, &Possible::probability);
}

}  // namespace

void decide(Work& w, std::vector<Tie>& ties) {
  Diagnosis& out = w.out;
  out.before = test(w, w.space, w.options.false_alarm);
  if (took_agreement_for_noise(w, out.before, w.options.false_alarm))
    out.before = test(w, w.space, w.options.false_alarm);
  out.fit = w.base;
  out.base = base_distance(out.fit);
  if (out.before.family_p > w.options.false_alarm) {
    auto wrong = reversal_left(w, w.base.model);
    if (!wrong) wrong = unsupported_noise(w);
    if (wrong) return leave_unexplained(w, {*wrong});
    out.verdict = out.effects.empty() ? Verdict::nothing_missing : Verdict::explained;
    return;
  }
  Naming n;
  if (!search_on_exact_model(w, n) || !drop_what_costs_nothing(w, n)) {
    leave_unexplained(w, significant(out.before, w.options.false_alarm));
    add_unexplained_tie(w, w.space, w.library, {}, ties);
    return;
  }
  out.base = base_distance(out.fit);
  const ResidualSpace left =
      residual_space(out.fit, w.readings, out.noise.sigma(), out.noise.correlation);
  out.after = test(w, left, w.options.inadequate);
  if (took_agreement_for_noise(w, out.after, w.options.inadequate)) return decide(w, ties);
  std::vector<Candidate> family = family_of(n.library, n.best, n.all);
  n.mean = average(n.library, family);
  std::erase_if(family, [&](const Candidate& c) {  // what is sure stays in
    for (std::size_t e = 0; e < n.mean.probability.size(); ++e) {
      if (n.mean.probability[e] >= kSure && !std::ranges::count(c.effects, static_cast<int>(e)))
        return true;
    }
    return false;
  });
  n.open = average(n.library, family, &Candidate::open_weight);
  name_effects(w, n);
  n.unnamed = best_unnamed(n.space, n.library, n.best, w.shapes, n.unnamed_score);
  n.alike = look_alikes(n.space, n.library, n.best, *w.history);
  if (const auto findings = objections(w, n); !findings.empty()) {
    leave_unexplained(w, findings);
    add_unexplained_tie(w, n.space, n.library, n.best, ties);
    return;
  }
  add_rivals(w, n, ties);
  if (w.one_length_mm && !out.rivals.empty()) {  // what is explained asks for nothing
    if (auto tie = tie_with_memory(n.library, n.best, *w.one_length_mm))
      ties.push_back(*std::move(tie));
  }
  add_possible(w, n);
  out.considered = runners_up(n.best, n.all);
  out.verdict = out.rivals.empty() ? Verdict::explained : Verdict::ambiguous;
}

void leave_to_the_screen(Work& w) {
  Diagnosis& out = w.out;
  out.verdict = Verdict::unexplained;
  out.fit.model = nominal_model(w.campaign.machine);
  out.notes.emplace_back(
      "nothing was fitted: what the screen found has to be put right first, in the campaign's "
      "files "
      "or in the wiring");
}

}  // namespace trammel
