#include "core/diagnose/naming.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/model/predictor.hpp"

namespace trammel {

namespace {

constexpr int kMostRounds = 6;  // of naming and exact fits: two are the rule

bool reaches(const RobotModel& model, std::span<const Reading> readings) {
  const Predictor expected(model);
  return std::ranges::all_of(readings,
                             [&](const Reading& r) { return expected.predict(r.conditions).ok(); });
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
      const auto known = std::ranges::find(library.remembered, effect, &ActiveEffect::effect);
      start.effects.push_back(
          {effect, known != library.remembered.end()
                       ? known->values
                       : Eigen::VectorXd::Zero(std::ssize(effect->parameters))});
    }
    for (std::size_t i = 0; i < unit.parameters.size(); ++i) {
      const double v = candidate.values[first + static_cast<Eigen::Index>(unit.column_at(i))];
      start.effects.back().values[unit.parameters[i]] = v != 0 ? v : 1e-12;
    }
    first += static_cast<Eigen::Index>(unit.columns.size());
  }
  while (!reaches(start, w.readings)) {
    for (ActiveEffect& active : start.effects) {
      for (int k = 0; k < active.values.size(); ++k) {
        if (!is_shape(*active.effect, k)) active.values[k] /= 4;
      }
    }
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

/// The space around the last fit, in which the effects of `remembered` take part as well.
void look_anew(Work& w, Naming& n, const std::vector<ActiveEffect>& remembered) {
  GeometryFit fit = w.out.fit;
  for (const ActiveEffect& idle : remembered) {
    if (std::ranges::find(fit.model.effects, idle.effect, &ActiveEffect::effect) ==
        fit.model.effects.end())
      fit.model.effects.push_back(idle);
  }
  n.space = undecided_space(fit, w.readings, w.out.noise.sigma(), w.out.noise.correlation);
  n.library = make_library(n.space);
}

/// Look-alikes with a name that do better than the effect of the best set they are taken for enter
/// the search, at their best shape. False where there is none.
bool admit(Work& w, Naming& n) {
  std::vector<ActiveEffect> remembered = n.space.remembered;
  for (const LookAlike& alike : look_alikes(n.space, n.library, n.best, *w.history)) {
    if (alike.evidence > 0 && alike.shape.effect != nullptr) remembered.push_back(alike.shape);
  }
  if (remembered.size() == n.space.remembered.size()) return false;
  look_anew(w, n, remembered);
  return true;
}

}  // namespace

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
    if (now == before && (round >= kMostRounds || !admit(w, n))) return true;
    if (now == before) continue;
    before = now;
    w.out.fit = fit_with(w, n.library, n.fitted);
    if (round == kMostRounds) return true;
    look_anew(w, n, n.space.remembered);
  }
}

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
        std = std::max(std, n.std_about(*column, value));
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
    for (int k = 0; k < active.values.size(); ++k) {
      const EffectParameter& chosen = active.effect->parameters[static_cast<std::size_t>(k)];
      if (chosen.on == On::choice)
        named.parameters.push_back({chosen.name, chosen.unit, active.values[k], 0, false});
    }
    std::vector<int> from_0;
    for (const int rail : named.rails) from_0.push_back(rail - 1);
    named.sentence = sentence_of(*active.effect, fit.model.nominal, from_0);
    named.share_of_gap = total > 0 ? n.loss[e] / total : 0;
    named.p = chi2_tail(n.loss[e], static_cast<double>(named.parameters.size()));
    w.out.effects.push_back(std::move(named));
  }
}

}  // namespace trammel
