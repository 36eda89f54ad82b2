#include "core/diagnose/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <utility>

#include "core/diagnose/average.hpp"
#include "core/diagnose/gap.hpp"
#include "core/diagnose/look_alikes.hpp"
#include "core/diagnose/noise.hpp"
#include "core/diagnose/selection.hpp"
#include "core/diagnose/unnamed.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kAssumedXyMm = 0.010;  // where neither tracker nor repeats say: only a first guess
constexpr double kAssumedPhiRad = rad_from_deg(0.01);
constexpr int kMostRounds = 6;      // of naming and exact fits: two are the rule
constexpr double kLarge = 10;       // chi^2 over its degrees of freedom
constexpr double kOneLength = 1.1;  // longest approach over the shortest
constexpr double kAdequate = 0.05;  // what named effects leave is white without any doubt

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

struct Work {
  const Campaign& campaign;
  const DiagnoseOptions& options;
  Diagnosis out = {};
  std::vector<Reading> readings;  // identify, without the bad ones
  GeometryFit base = {};
  ResidualSpace space = {};        // around the base
  std::vector<Shape> shapes = {};  // dictionary and catalogue
  Library library = {};
  bool agreement_taken = false;              // agreement of successive readings was taken for noise
  std::optional<double> one_length_mm = {};  // of all approaches, where it is one
  std::vector<int> certain = {};             // seqs that are wrong whatever the model is
};

/// The best set, and what else was looked at, around its exact fit.
struct Naming {
  ResidualSpace space;  // around the fit, effects given back
  Library library;
  std::vector<Candidate> all;
  Candidate best;            // what earns its price
  Candidate fitted;          // with the rails that may stand for others
  std::vector<double> loss;  // of chi^2 on the exact model without each effect of `best`
  Average mean;
  std::optional<Finding> unnamed;  // shape that does best in place of an effect
  double unnamed_score = 0;
  std::vector<LookAlike> alike;
};

/// A linearisation, and the catalogue's signals in it.
struct Around {
  ResidualSpace space;
  Library library;
};

std::vector<Reading> of_set(const Campaign& campaign, ReadingSet set) {
  std::vector<Reading> readings;
  for (const Reading& r : campaign.readings) {
    if (r.set == set && (r.measured || set == ReadingSet::predict)) readings.push_back(r);
  }
  return readings;
}

void require_enough(const Work& w) {
  const auto parameters = base_parameters(w.campaign.machine, w.readings).size();
  const auto coordinates = static_cast<std::size_t>(measured_by(nominal_model(w.campaign.machine)));
  if (coordinates * w.readings.size() >= parameters + 9) return;
  throw InputError({.what = "too few readings to look for a missing effect",
                    .got = std::to_string(w.readings.size()) + " identify readings",
                    .expected = "at least " +
                                std::to_string((parameters + 9 + coordinates - 1) / coordinates) +
                                " for " + std::to_string(parameters) + " parameters of the base",
                    .hint = "measure more points, or use 'calibrate lsq'"});
}

void fit_base(Work& w) {
  const NoiseFloor& noise = w.out.noise;
  w.base = fit_geometry(nominal_model(w.campaign.machine), w.readings, noise.sigma(),
                        {.correlation = noise.correlation});
  w.space = residual_space(w.base, w.readings, noise.sigma(), noise.correlation);
  w.library = make_library(w.space);
}

/// Step 1: whose word on the noise is taken first.
void first_noise(Work& w) {
  NoiseFloor& noise = w.out.noise;
  noise.repeats = pooled_noise(w.campaign.readings, w.campaign.machine.measured);
  if (w.campaign.tracker ||
      (noise.repeats && noise.repeats->degrees_of_freedom >= kEnoughRepeats)) {
    const NoiseLevel level = noise_level(w.campaign);
    noise.stated = level.stated.value_or(TrackerSigma{});
    noise.used = level.sigma;
    noise.degrees_of_freedom = level.degrees_of_freedom;
    noise.source =
        level.source == NoiseLevel::Source::tracker ? NoiseSource::tracker : NoiseSource::repeats;
    if (level.doubted) w.out.notes.push_back(level.words);
  } else {
    noise.used = {kAssumedXyMm, kAssumedPhiRad};
    noise.source = NoiseSource::residuals;
    w.out.notes.push_back(
        "no sigma is stated and there are too few repeats: the noise is what base and catalogue "
        "leave, so structure "
        "that looks like noise can't be seen");
  }
  noise.first = noise.used;
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

bool search_on_exact_model(Work& w, Naming& n);

/// Base and catalogue as the noise is judged by: around the exact fit of what is found first where
/// that is large. Second order of a lead 1.6 % off is several sigmas at the ends of the rails, and
/// no single bad readings.
Around around_what_is_large(Work& w) {
  Naming n;
  const bool large = w.base.chi2 > kLarge * w.base.dof;
  if (!large || !search_on_exact_model(w, n)) return {w.space, w.library};
  return {std::move(n.space), std::move(n.library)};
}

/// Two axes are read by an instrument each: y has a noise of its own where its residuals are not of
/// the size of x's beyond chance. True when that changed.
bool settle_axes(Work& w, const NoiseRatio& ratio) {
  if (!w.space.machine.kind->has_point_platform()) return false;
  if (!other_size(ratio.y / ratio.x, ratio.y_dof, ratio.x_dof)) return false;
  NoiseFloor& noise = w.out.noise;
  noise.used.xy_mm *= ratio.x;
  noise.y_over_x *= ratio.y / ratio.x;
  noise.rescaled = noise.source != NoiseSource::residuals;
  fit_base(w);
  return true;
}

/// White residuals of another size than was stated are not structure: scale, and go on.
void settle_noise(Work& w) {
  for (int round = 0; round < 3; ++round) {
    const Around at = around_what_is_large(w);
    const NoiseRatio ratio = noise_ratio(at.space, at.library.signals);
    const bool unknown = w.out.noise.source == NoiseSource::residuals;
    const int repeats = w.out.noise.degrees_of_freedom;
    if (settle_axes(w, ratio)) continue;
    const bool xy = unknown || other_size(ratio.xy, ratio.xy_dof, 2 * repeats);
    const bool phi = unknown || other_size(ratio.phi, ratio.phi_dof, repeats);
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
        fit_geometry(w.base.model, w.readings, w.out.noise.sigma(), {.correlation = rho}),
        w.readings, w.out.noise.sigma(), rho);
  };
  w.out.noise.correlation = noise_correlation(space_with, known);
  if (w.out.noise.correlation == 0) return;
  w.out.notes.emplace_back(
      w.out.noise.correlation > 0
          ? "the noise of successive readings is correlated: it is taken out before anything is "
            "tested"
          : "the noise of successive readings alternates: that is taken out before anything is "
            "tested");
  fit_base(w);
}

/// Far readings of noise with heavy tails are noise: they are drawn in, and leave the verdict
/// alone. Where the far ones are structure (a bump, a stretch of time), exchanging the readings
/// does not show it again, and nothing is drawn in.
void settle_tails(Work& w) {
  const Around at_fit = around_what_is_large(w);
  auto tails = heavy_tails(at_fit.space, at_fit.library.signals);
  if (!tails) return;
  ResidualSpace left = at_fit.space;
  Eigen::MatrixXd all(left.rows(), left.Q.cols() + at_fit.library.signals.cols());
  all << left.Q, left.project(at_fit.library.signals);
  for (Eigen::Index j = left.Q.cols(); j < all.cols(); ++j) all.col(j).normalize();
  left.Q = orthonormal(all);
  left.residual = left.project(left.residual);
  const StructureTest structure = test_structure(left, dictionary(left),
                                                 {.replicates = w.options.replicates,
                                                  .level = w.options.false_alarm,
                                                  .seed = w.options.seed,
                                                  .threads = w.options.threads,
                                                  .exchange = true});
  if (structure.family_p <= w.options.false_alarm) return;
  NamedEffect bad;
  bad.name = "outlier_readings";
  bad.p = kFalseOutlier;
  for (std::size_t i = 0; i < tails->far.size(); ++i) {
    const std::size_t at = tails->far[i];
    const bool gross = std::ranges::find(tails->gross, at) != tails->gross.end();
    if (gross) {
      bad.seqs.push_back(w.readings[at].seq);
    } else {
      w.out.suspicious.push_back(
          {w.readings[at].seq, tails->sigmas[i], "the noise has heavy tails"});
    }
  }
  w.readings = std::move(tails->readings);
  for (auto it = tails->gross.rbegin(); it != tails->gross.rend(); ++it) {
    w.readings.erase(w.readings.begin() + static_cast<std::ptrdiff_t>(*it));
  }
  if (!bad.seqs.empty()) w.out.effects.push_back(std::move(bad));
  w.out.noise.robust = true;
  w.out.notes.emplace_back(
      "the noise has heavier tails than a normal distribution: the fit is robust, readings far off "
      "count as if they were " +
      text_of(kWinsor[static_cast<std::size_t>(w.space.coordinates())]) + " sigma away");
  fit_base(w);
}

/// Readings that are wrong whatever the model is: no fit begins with them.
void drop_certain_readings(Work& w, const std::vector<Suspicion>& found) {
  for (const Suspicion& s : found) {
    if (s.kind != Mistake::stale && s.kind != Mistake::missed && s.kind != Mistake::far) continue;
    const auto gone =
        std::erase_if(w.readings, [&](const Reading& r) { return r.seq == s.seqs.front(); });
    if (gone > 0) w.certain.push_back(s.seqs.front());
  }
}

/// Single bad readings first, where the tails are normal: four outliers must not become seven
/// effects.
void drop_bad_readings(Work& w) {
  NamedEffect bad;
  bad.name = "outlier_readings";
  bad.seqs = w.certain;
  for (int round = 0; round < 5 && !w.out.noise.robust; ++round) {
    const Around at = around_what_is_large(w);
    const auto places = bad_readings(at.space, at.library.signals);
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

bool reaches(const RobotModel& model, std::span<const Reading> readings) {
  return std::ranges::all_of(readings,
                             [&](const Reading& r) { return predict(model, r.conditions).ok(); });
}

/// The base with the candidate's effects, fitted on the exact model. Values that a wild reading has
/// driven out of the robot's reach are where no fit can begin: it begins nearer to the base.
GeometryFit fit_with(const Work& w, const Library& library, const Candidate& candidate) {
  RobotModel start = w.base.model;
  Eigen::Index first = 0;
  for (const int u : candidate.units) {
    const Unit& unit = library.units[static_cast<std::size_t>(u)];
    const Effect* effect = &effect_catalogue()[static_cast<std::size_t>(unit.effect)];
    if (start.effects.empty() || start.effects.back().effect != effect) {
      start.effects.push_back(
          {effect, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(effect->parameters.size()))});
    }
    for (std::size_t i = 0; i < unit.parameters.size(); ++i) {
      const double v = candidate.values[first + static_cast<Eigen::Index>(unit.column_at(i))];
      start.effects.back().values[unit.parameters[i]] = v != 0 ? v : 1e-12;
    }
    first += static_cast<Eigen::Index>(unit.columns.size());
  }
  while (!reaches(start, w.readings)) {
    for (ActiveEffect& active : start.effects) active.values /= 4;
  }
  return fit_geometry(start, w.readings, w.out.noise.sigma(),
                      {.correlation = w.out.noise.correlation});
}

/// (effect, parameter) of every parameter fitted: the same in any library.
std::vector<std::pair<int, int>> parameters_of(const Library& library, const Candidate& c) {
  std::vector<std::pair<int, int>> parameters;
  for (const int u : c.units) {
    const Unit& unit = library.units[static_cast<std::size_t>(u)];
    for (const int k : unit.parameters) parameters.emplace_back(unit.effect, k);
  }
  return parameters;
}

std::vector<int> units_without(const Library& library, const Candidate& c, int effect) {
  std::vector<int> units = c.units;
  std::erase_if(units,
                [&](int u) { return library.units[static_cast<std::size_t>(u)].effect == effect; });
  return units;
}

std::optional<Candidate> solved(const Library& library, const std::vector<int>& units) {
  return units.empty() ? std::nullopt : solve(library, units);
}

/// Searches, fits the best set on the exact model, and searches again around that fit, until the
/// same set comes back. False when no set earns its price.
bool search_on_exact_model(Work& w, Naming& n) {
  n.space = w.space;
  n.library = w.library;
  std::vector<std::pair<int, int>> before;
  for (int round = 1;; ++round) {
    n.all = search(n.library, 3);
    if (n.all.empty() || n.all.front().score <= 0) return false;
    n.best = extend(n.library, n.all.front());
    n.fitted = with_all_rails(n.library, n.best);
    const auto now = parameters_of(n.library, n.fitted);
    if (now == before) return true;
    before = now;
    w.out.fit = fit_with(w, n.library, n.fitted);
    if (round == kMostRounds) return true;
    n.space = undecided_space(w.out.fit, w.readings, w.out.noise.sigma(), w.out.noise.correlation);
    n.library = make_library(n.space);
  }
}

/// What the exact fit loses without each effect; an effect whose loss does not pay its price goes,
/// the cheapest first. False when none is left.
bool drop_what_costs_nothing(Work& w, Naming& n) {
  for (;;) {
    n.loss.clear();
    std::optional<std::size_t> cheapest;
    double least = 0;
    for (std::size_t e = 0; e < n.best.effects.size(); ++e) {
      const int effect = n.best.effects[e];
      const auto others = solved(n.library, units_without(n.library, n.fitted, effect));
      const double chi2 = others ? fit_with(w, n.library, *others).chi2 : w.base.chi2;
      n.loss.push_back(chi2 - w.out.fit.chi2);
      const double price = price_of(n.library, n.best.units) -
                           price_of(n.library, units_without(n.library, n.best, effect));
      if (n.loss.back() - price >= least) continue;
      least = n.loss.back() - price;
      cheapest = e;
    }
    if (!cheapest) return true;
    const auto rest =
        solved(n.library, units_without(n.library, n.best, n.best.effects[*cheapest]));
    if (!rest) return false;
    n.best = *rest;
    n.fitted = with_all_rails(n.library, n.best);
    w.out.fit = fit_with(w, n.library, n.fitted);
  }
}

/// An inch's lead taken for a metric one, or the other way about; nothing where k is neither.
std::string ratio_in_words(double k, double std) {
  constexpr std::pair<double, double> kLeadsMm[] = {{25.4, 25}, {25, 25.4}};
  for (const auto& [is, taken] : kLeadsMm) {
    const double off = is / taken - 1;
    if (std > 0.1 * std::abs(off) || std::abs(k - off) > 3 * std) continue;
    return " is the ratio " + text_of(is) + " / " + text_of(taken) +
           ": a lead in inches, or taken for one";
  }
  return {};
}

void name_effects(Work& w, const Naming& n) {
  const GeometryFit& fit = w.out.fit;
  double total = 0;
  for (const double loss : n.loss) total += loss;
  for (std::size_t e = 0; e < fit.model.effects.size(); ++e) {
    const ActiveEffect& active = fit.model.effects[e];
    const int place = static_cast<int>(active.effect - effect_catalogue().data());
    NamedEffect named;
    named.name = active.effect->name;
    for (std::size_t j = 0; j < fit.parameters.size(); ++j) {
      const FreeParameter& p = fit.parameters[j];
      if (p.kind != FreeParameter::Kind::effect || p.owner != static_cast<int>(e)) continue;
      const EffectParameter& about = active.effect->parameters[static_cast<std::size_t>(p.index)];
      const auto jj = static_cast<Eigen::Index>(j);
      const double value = active.values[p.index];
      double std = p.scale * std::sqrt(fit.covariance(jj, jj));
      if (const auto column = column_of(n.library, place, p.index))
        std = std::max(std, n.mean.std_about(*column, value));
      named.parameters.push_back(
          {about.name, about.unit, value, std,
           value > about.usual_max + 2 * std || value < about.low() - 2 * std});
      if (about.rail >= 0 && (named.rails.empty() || named.rails.back() != about.rail + 1)) {
        named.rails.push_back(about.rail + 1);
      }
      if (named.name == "lead_scale") {
        if (const std::string ratio = ratio_in_words(value, std); !ratio.empty())
          w.out.notes.push_back("1 + " + about.name + " of lead_scale" + ratio);
      }
    }
    std::vector<int> from_0;
    for (const int rail : named.rails) from_0.push_back(rail - 1);
    named.sentence = sentence_of(*active.effect, fit.model.nominal, from_0);
    named.share_of_gap = total > 0 ? n.loss[e] / total : 0;
    named.p = chi2_tail(n.loss[e], static_cast<double>(named.parameters.size()));
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
  for (const Reading& r : of_set(w.campaign, ReadingSet::validate)) {
    const Prediction at = predict(model, r.conditions);
    if (!at.ok()) return INFINITY;
    const Eigen::Vector3d d = r.measured->vector() - at.pose.vector();
    sum += d.cwiseQuotient(w.out.noise.sigma().of(model.nominal.measured)).squaredNorm();
  }
  return sum;
}

/// Why the named set can't stand: what it leaves, or what explains more; nothing when it can.
std::vector<Finding> objections(const Work& w, const Naming& n) {
  if (!n.best.usual) {
    return {{drives_name(*w.space.machine.kind),
             "named effects need a sign that they can't have (an overshoot is no backlash)",
             chi2_tail(n.best.gain, n.best.parameters), n.best.gain, n.best.parameters}};
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

/// What the average over sets says beside the named ones.
void add_possible(Work& w, const Naming& n) {
  for (std::size_t e = 0; e < n.mean.probability.size(); ++e) {
    const bool named =
        std::ranges::find(n.best.effects, static_cast<int>(e)) != n.best.effects.end();
    if (named || n.mean.probability[e] < kPossible) continue;
    w.out.may_also_hold.push_back({effect_catalogue()[e].name, n.mean.probability[e]});
  }
  std::ranges::stable_sort(w.out.may_also_hold, std::greater{}, &Possible::probability);
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
  Naming n;
  if (!search_on_exact_model(w, n) || !drop_what_costs_nothing(w, n)) {
    leave_unexplained(w, significant(out.before, w.options.false_alarm));
    add_unexplained_tie(w, w.space, w.library, {}, ties);
    return;
  }
  const ResidualSpace left =
      residual_space(out.fit, w.readings, out.noise.sigma(), out.noise.correlation);
  out.after = test(w, left, w.options.inadequate);
  if (took_agreement_for_noise(w, out.after, w.options.inadequate)) return decide(w, ties);
  n.mean = average(n.library, family_of(n.library, n.best, n.all));
  name_effects(w, n);
  n.unnamed = best_unnamed(n.space, n.library, n.best, w.shapes, n.unnamed_score);
  n.alike = look_alikes(n.space, n.library, n.best, w.campaign.readings);
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

/// Wires, signs, frames or units are wrong: nothing is fitted, and no effect is named.
void leave_to_the_screen(Work& w) {
  Diagnosis& out = w.out;
  out.verdict = Verdict::unexplained;
  out.fit.model = nominal_model(w.campaign.machine);
  out.notes.emplace_back(
      "nothing was fitted: what the screen found has to be put right first, in the campaign's "
      "files "
      "or in the wiring");
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
    for (const AtTarget& at : w.out.by_target)
      w.out.notes.push_back(in_words(at, campaign.machine));
  }
  for (const Reading& r : of_set(campaign, ReadingSet::predict)) {
    const PredictedPose p = predict_with_covariance(w.out.fit, r.conditions);
    w.out.predictions.push_back({r.seq, p.pose, p.covariance.diagonal().cwiseSqrt()});
  }
  return w.out;
}

}  // namespace trammel
