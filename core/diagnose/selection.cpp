#include "core/diagnose/selection.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/linear/decompositions.hpp"

namespace trammel {

namespace {

constexpr double kVisibleSigmas =
    2.0;                            // an effect at its usual maximum must move the readings by more
constexpr double kOutOfSight = 30;  // below the best score: neither a rival nor in any average
constexpr double kCollinear = 1e-9;  // share of a column that must survive the others of its set

/// Of the parameters that the machine has.
std::vector<std::vector<int>> units_of(const Effect& effect, const Machine& machine) {
  std::vector<std::vector<int>> units;
  for (int k = 0; k < static_cast<int>(effect.parameters.size()); ++k) {
    if (!exists(effect, k, machine)) continue;
    if (effect.parameters[static_cast<std::size_t>(k)].joined && !units.empty()) {
      units.back().push_back(k);
    } else {
      units.push_back({k});
    }
  }
  return units;
}

/// One parameter on each drive or guide: the same cause (screws of one batch, one steel, one kind
/// of nut) may act on all of them by the same amount, which is one parameter, not several that
/// happen to agree.
bool one_per_rail_of(const Effect& effect, const Machine& machine) {
  int drives = 0;
  for (int k = 0; k < static_cast<int>(effect.parameters.size()); ++k)
    drives += is_shape(effect, k) ? 0 : 1;
  if (drives != kChains || machine.kind->n_chains < 2) return false;
  for (int k = 0; k < kChains; ++k) {
    const EffectParameter& p = effect.parameters[static_cast<std::size_t>(k)];
    if (p.rail != k || p.joined) return false;
  }
  return true;
}

/// Those with a memory take part where a look-alike asked for them.
bool testable(const Effect& effect, const ResidualSpace& space) {
  if (effect.recall != nullptr &&
      std::ranges::find(space.remembered, &effect, &ActiveEffect::effect) == space.remembered.end())
    return false;
  return std::all_of(space.predictions.begin(), space.predictions.end(),
                     [&](const Prediction& at) { return recorded(effect, at.moment); });
}

double units_per_effect(const Library& library, int effect) {
  return static_cast<double>(
      std::count_if(library.units.begin(), library.units.end(),
                    [effect](const Unit& unit) { return unit.effect == effect && !unit.common; }));
}

/// Calls f with every non-empty choice of `units` for each effect of the set, joined; what is
/// common to all rails stands alone.
template <typename F>
void each_choice(const Library& library, const std::vector<std::vector<int>>& units_of_effects,
                 std::size_t at, std::vector<int>& chosen, F f) {
  if (at == units_of_effects.size()) {
    f(chosen);
    return;
  }
  const auto& units = units_of_effects[at];
  for (unsigned mask = 1; mask < (1U << units.size()); ++mask) {
    const std::size_t before = chosen.size();
    bool common = false;
    for (std::size_t u = 0; u < units.size(); ++u) {
      if ((mask >> u & 1U) == 0) continue;
      chosen.push_back(units[u]);
      common = common || library.units[static_cast<std::size_t>(units[u])].common;
    }
    if (!common || chosen.size() == before + 1) {
      each_choice(library, units_of_effects, at + 1, chosen, f);
    }
    chosen.resize(before);
  }
}

/// As solve(); without the standard deviations of values where a search has no use for them.
std::optional<Candidate> solved(const Library& library, const std::vector<int>& units,
                                bool with_std) {
  Candidate c;
  c.units = units;
  std::vector<int> columns;
  for (const int u : units) {
    const Unit& unit = library.units[static_cast<std::size_t>(u)];
    columns.insert(columns.end(), unit.columns.begin(), unit.columns.end());
    if (c.effects.empty() || c.effects.back() != unit.effect) c.effects.push_back(unit.effect);
  }
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd G(n, n);
  Eigen::VectorXd b(n), scale(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int ci = columns[static_cast<std::size_t>(i)];
    const double prior = 1 / (library.usual_max[ci] * library.usual_max[ci]);
    scale[i] = 1 / std::sqrt(library.gram(ci, ci) + prior);
    b[i] = library.moment[ci] * scale[i];
    for (Eigen::Index j = 0; j <= i; ++j) {
      G(i, j) = library.gram(ci, columns[static_cast<std::size_t>(j)]) * scale[i] * scale[j];
    }
    G(i, i) = 1;
  }
  const Cholesky factor(std::move(G));
  if (!factor.ok() || factor.pivots().minCoeff() < kCollinear) return std::nullopt;
  const Eigen::VectorXd scaled = factor.solve(b);
  c.gain = b.dot(scaled);
  c.values = scaled.cwiseProduct(scale);
  c.parameters = static_cast<int>(n);
  const auto impossible = [&](Eigen::Index i, double slack) {
    const double low = library.usual_min[columns[static_cast<std::size_t>(i)]];
    return low >= 0 && c.values[i] < -slack;
  };
  bool wrong_sign = false;
  for (Eigen::Index i = 0; i < n; ++i) wrong_sign = wrong_sign || impossible(i, 0);
  if (with_std || wrong_sign) c.std = factor.inverse().diagonal().cwiseSqrt().cwiseProduct(scale);
  for (Eigen::Index i = 0; wrong_sign && i < n; ++i)
    c.usual = c.usual && !impossible(i, 2 * c.std[i]);
  c.occam = factor.log_determinant() +
            2 * std::log((library.usual_max(columns).array() / scale.array()).prod());
  const double possible = c.gain - (c.usual ? 0 : kPriceOfImpossible);
  const double price = price_of(library, units);
  c.score = possible - price;
  c.weight = possible -
             std::min(price, c.occam + kPriceOfPresence * static_cast<double>(c.effects.size()));
  return c;
}

std::optional<Candidate> best_choice(const Library& library,
                                     const std::vector<std::vector<int>>& units_of_effects,
                                     int most_parameters) {
  std::optional<Candidate> best;
  std::vector<int> chosen;
  each_choice(library, units_of_effects, 0, chosen, [&](const std::vector<int>& units) {
    if (most_parameters > 0 && parameter_count(library, units) > most_parameters) return;
    auto c = solved(library, units, false);
    if (c && (!best || c->score > best->score)) best = std::move(c);
  });
  return best ? solve(library, best->units) : best;
}

/// Units of an effect: `choices` with what is common to all rails, which the others can say as
/// well.
std::vector<int> all_units(const Library& library, int effect, bool choices = false) {
  std::vector<int> units;
  for (std::size_t u = 0; u < library.units.size(); ++u) {
    const Unit& unit = library.units[u];
    if (unit.effect == effect && (choices || !unit.common)) units.push_back(static_cast<int>(u));
  }
  return units;
}

/// Bound on the score of any choice of units: the gain of all of them at the price of the cheapest.
/// (What a value on all rails costs by its range is counted three times: far below kOutOfSight.)
double most_they_can_score(const Library& library,
                           const std::vector<std::vector<int>>& units_of_effects) {
  std::vector<int> every;
  double price = 0;
  for (const std::vector<int>& units : units_of_effects) {
    std::size_t fewest = kChains * kChains;
    for (const int u : units) {
      const Unit& unit = library.units[static_cast<std::size_t>(u)];
      if (!unit.common) every.push_back(u);
      fewest = std::min(fewest, unit.columns.size());
    }
    price += kPriceOfName + kPriceOfParameter * static_cast<double>(fewest);
  }
  const auto c = solved(library, every, false);
  return c ? c->gain - price : INFINITY;
}

std::vector<int> with_units(std::vector<int> units, const std::vector<int>& added) {
  units.insert(units.end(), added.begin(), added.end());
  std::sort(units.begin(), units.end());
  return units;
}

/// Of Candidate: the marginal likelihood with widths W by which each column alone would give a gain
/// of `most`, no wider than usual, gain - ln det(I + W G W).
double open_weight(const Library& library, const Candidate& c, double most) {
  std::vector<int> columns;
  for (const int u : c.units) {
    const auto& own = library.units[static_cast<std::size_t>(u)].columns;
    columns.insert(columns.end(), own.begin(), own.end());
  }
  Eigen::MatrixXd A = library.gram(columns, columns);
  const Eigen::VectorXd width =
      (most / A.diagonal().array()).sqrt().min(library.usual_max(columns).array()).matrix();
  A = width.asDiagonal() * A * width.asDiagonal();
  A.diagonal().array() += 1;
  return c.gain - Cholesky(std::move(A)).log_determinant();
}

}  // namespace

std::optional<Candidate> solve(const Library& library, const std::vector<int>& units) {
  return solved(library, units, true);
}

int parameter_count(const Library& library, const std::vector<int>& units) {
  std::size_t n = 0;
  for (const int u : units) n += library.units[static_cast<std::size_t>(u)].columns.size();
  return static_cast<int>(n);
}

double price_of(const Library& library, const std::vector<int>& units) {
  double price = 0;
  int last = -1;
  for (const int u : units) {
    const Unit& unit = library.units[static_cast<std::size_t>(u)];
    const auto n = static_cast<double>(unit.columns.size());
    price += unit.effect == last
                 ? kPriceOfFurther * n + 2 * std::log(units_per_effect(library, unit.effect))
                 : kPriceOfName + kPriceOfParameter * n +
                       (effect_catalogue()[static_cast<std::size_t>(unit.effect)].recall != nullptr
                            ? kPriceOfShape
                            : 0);
    last = unit.effect;
  }
  return price;
}

Library make_library(const ResidualSpace& space) {
  Library library;
  library.remembered = space.remembered;
  const auto catalogue = effect_catalogue();
  std::vector<Eigen::VectorXd> columns;
  std::vector<double> highest, lowest;
  for (std::size_t e = 0; e < catalogue.size(); ++e) {
    const Effect& effect = catalogue[e];
    if (!testable(effect, space)) continue;
    for (const auto& parameters : units_of(effect, space.machine)) {
      Unit unit{static_cast<int>(e), parameters, {}};
      std::vector<Eigen::VectorXd> own;
      bool visible = true;
      for (const int k : parameters) {
        own.push_back(whitened_signal(
            space, [&](const Reading&, const Moment& m) { return effect.basis(m, k); }));
        const double usual = effect.parameters[static_cast<std::size_t>(k)].usual_max;
        visible = visible && space.project(own.back()).norm() * usual > kVisibleSigmas;
      }
      if (!visible) continue;
      for (std::size_t i = 0; i < own.size(); ++i) {
        const auto& p = effect.parameters[static_cast<std::size_t>(parameters[i])];
        unit.columns.push_back(static_cast<int>(columns.size()));
        columns.push_back(own[i]);
        highest.push_back(p.usual_max);
        lowest.push_back(p.low());
      }
      library.units.push_back(unit);
    }
    if (!one_per_rail_of(effect, space.machine)) continue;
    Unit common{static_cast<int>(e), {}, {static_cast<int>(columns.size())}, true};
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(space.rows());
    double least_usual = INFINITY;
    for (const Unit& unit : library.units) {
      if (unit.effect != common.effect) continue;
      common.parameters.push_back(unit.parameters.front());
      sum += columns[static_cast<std::size_t>(unit.columns.front())];
      least_usual = std::min(least_usual, highest[static_cast<std::size_t>(unit.columns.front())]);
    }
    if (std::ssize(common.parameters) < space.machine.kind->n_chains ||
        space.project(sum).norm() * least_usual <= kVisibleSigmas)
      continue;
    columns.push_back(std::move(sum));
    highest.push_back(least_usual);
    lowest.push_back(effect.parameters.front().low());
    library.units.push_back(std::move(common));
  }
  const auto n = static_cast<Eigen::Index>(columns.size());
  library.signals.resize(space.rows(), n);
  for (Eigen::Index i = 0; i < n; ++i)
    library.signals.col(i) = columns[static_cast<std::size_t>(i)];
  library.usual_max = Eigen::Map<Eigen::VectorXd>(highest.data(), n);
  library.usual_min = Eigen::Map<Eigen::VectorXd>(lowest.data(), n);
  const Eigen::MatrixXd projected = space.project(library.signals);
  library.gram = gram(projected);
  library.moment = transposed_times(projected, space.residual);
  return library;
}

std::vector<Candidate> search(const Library& library, int most, int most_parameters) {
  std::vector<std::vector<int>> units(effect_catalogue().size());
  for (std::size_t u = 0; u < library.units.size(); ++u) {
    units[static_cast<std::size_t>(library.units[u].effect)].push_back(static_cast<int>(u));
  }
  std::vector<Candidate> all;
  double highest = 0;
  const auto consider = [&](const std::vector<std::size_t>& effects) {
    std::vector<std::vector<int>> chosen;
    for (const std::size_t e : effects) {
      if (units[e].empty()) return;
      chosen.push_back(units[e]);
    }
    if (effects.size() > 1 && most_they_can_score(library, chosen) < highest - kOutOfSight) return;
    const auto c = best_choice(library, chosen, most_parameters);
    if (!c) return;
    all.push_back(*c);
    highest = std::max(highest, c->score);
  };
  const std::size_t n = units.size();
  for (std::size_t a = 0; a < n; ++a) consider({a});
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = a + 1; b < n && most >= 2; ++b) {
      consider({a, b});
      for (std::size_t c = b + 1; c < n && most >= 3; ++c) consider({a, b, c});
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  return all;
}

std::vector<Candidate> rivals_of(const Candidate& best, const std::vector<Candidate>& all) {
  std::vector<Candidate> rivals;
  for (const Candidate& c : all) {
    const bool superset =
        std::includes(c.effects.begin(), c.effects.end(), best.effects.begin(), best.effects.end());
    if (superset || !c.usual) continue;
    if (c.score >= best.score - kEvidence20To1) rivals.push_back(c);
  }
  return rivals;
}

std::vector<Candidate> family_of(const Library& library, const Candidate& best,
                                 const std::vector<Candidate>& all) {
  std::vector<double> opens;
  double highest = best.weight, highest_open = open_weight(library, best, best.gain);
  for (const Candidate& c : all) {
    opens.push_back(open_weight(library, c, best.gain));
    highest = std::max(highest, c.weight);
    highest_open = std::max(highest_open, opens.back());
  }
  std::vector<std::vector<int>> sets;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].usual && (std::max(all[i].score, all[i].weight) >= highest - kFamily ||
                         opens[i] >= highest_open - kFamily))
      sets.push_back(all[i].effects);
  }
  std::vector<Candidate> family;
  const auto keep = [&](const std::vector<int>& units) {
    auto c = solved(library, units, false);
    if (!c || !c->usual) return;
    const double open = open_weight(library, *c, best.gain);
    if (c->weight < highest - kFamily && open < highest_open - kFamily) return;
    c = solve(library, units);
    c->open_weight = open;
    family.push_back(*std::move(c));
  };
  const bool searched = best.effects.size() <= kMostSearched;
  if (!searched) keep(best.units);
  for (int e = 0; e < static_cast<int>(effect_catalogue().size()); ++e) {
    if (searched) {
      sets.push_back(best.effects);
      sets.back().push_back(e);
      std::sort(sets.back().begin(), sets.back().end());
    } else if (std::ranges::find(best.effects, e) == best.effects.end()) {
      // Of a larger set the choices of rails multiply beyond count: its own stay as they are.
      const std::vector<std::vector<int>> units = {all_units(library, e, true)};
      if (units.front().empty()) continue;
      std::vector<int> chosen;
      each_choice(library, units, 0, chosen,
                  [&](const std::vector<int>& these) { keep(with_units(best.units, these)); });
    }
  }
  if (searched) sets.push_back(best.effects);
  std::sort(sets.begin(), sets.end());
  sets.erase(std::unique(sets.begin(), sets.end()), sets.end());
  for (const std::vector<int>& effects : sets) {
    std::vector<std::vector<int>> units;
    for (const int e : effects) units.push_back(all_units(library, e, true));
    const bool once = std::adjacent_find(effects.begin(), effects.end()) == effects.end();
    if (!once || std::ranges::any_of(units, [](const auto& u) { return u.empty(); })) continue;
    std::vector<int> chosen;
    each_choice(library, units, 0, chosen, keep);
  }
  return family;
}

double gain_of(const Library& library, const std::vector<int>& units) {
  if (units.empty()) return 0;
  const auto c = solve(library, units);
  return c ? c->gain : 0;
}

Candidate extend(const Library& library, Candidate best) {
  for (;;) {
    std::optional<Candidate> next;
    for (std::size_t e = 0; e < effect_catalogue().size(); ++e) {
      const int effect = static_cast<int>(e);
      if (std::count(best.effects.begin(), best.effects.end(), effect) > 0) continue;
      std::vector<int> chosen;
      const std::vector<int> own = all_units(library, effect, true);
      if (own.empty()) continue;
      each_choice(library, {own}, 0, chosen, [&](const std::vector<int>& added) {
        const auto c = solve(library, with_units(best.units, added));
        if (c && (!next || c->score > next->score)) next = c;
      });
    }
    if (!next || next->score <= best.score) return best;
    best = *next;
  }
}

Candidate with_all_rails(const Library& library, const Candidate& best) {
  Candidate wider = best;
  const auto widen = [&](int unit) {
    std::vector<int> units = wider.units;
    units.insert(std::upper_bound(units.begin(), units.end(), unit), unit);
    if (const auto c = solve(library, units)) wider = *c;
  };
  const auto exchanged = [&](int out, int in) {
    std::vector<int> units = best.units;
    std::replace(units.begin(), units.end(), out, in);
    std::sort(units.begin(), units.end());
    return gain_of(library, units);
  };
  for (std::size_t v = 0; v < library.units.size(); ++v) {
    const int unit = static_cast<int>(v);
    const Unit& about = library.units[v];
    if (std::count(best.units.begin(), best.units.end(), unit) > 0) continue;
    if (std::count(best.effects.begin(), best.effects.end(), about.effect) == 0) continue;
    const bool on_all = about.common || std::ranges::any_of(best.units, [&](int own) {
                          const Unit& named = library.units[static_cast<std::size_t>(own)];
                          return named.common && named.effect == about.effect;
                        });
    if (on_all) continue;
    const bool stands_for = std::any_of(best.units.begin(), best.units.end(), [&](int own) {
      return library.units[static_cast<std::size_t>(own)].effect == about.effect &&
             exchanged(own, unit) > best.gain - kStandsFor;
    });
    if (stands_for) widen(unit);
  }
  return wider;
}

std::vector<Candidate> structural_ties(const Library& library, const Candidate& best) {
  constexpr double kCannotTell = 4;  // chi^2: what is left of the signal is lost in the noise
  std::vector<Candidate> ties;
  for (const int effect : best.effects) {
    std::vector<int> others;
    for (const int u : best.units) {
      if (library.units[static_cast<std::size_t>(u)].effect != effect) others.push_back(u);
    }
    // the effect's fitted signal, as moments against the library
    Library alone = library;
    alone.moment.setZero();
    Eigen::Index at = 0;
    double energy = 0;
    for (const int u : best.units) {
      const Unit& unit = library.units[static_cast<std::size_t>(u)];
      for (const int column : unit.columns) {
        const double value = best.values[at++];
        if (unit.effect == effect) alone.moment += value * library.gram.col(column);
      }
    }
    at = 0;
    for (const int u : best.units) {
      const Unit& unit = library.units[static_cast<std::size_t>(u)];
      for (const int column : unit.columns) {
        const double value = best.values[at++];
        if (unit.effect == effect) energy += value * alone.moment[column];
      }
    }
    for (std::size_t e = 0; e < effect_catalogue().size(); ++e) {
      const int other = static_cast<int>(e);
      if (std::count(best.effects.begin(), best.effects.end(), other) > 0) continue;
      const std::vector<int> own = all_units(library, other);
      if (own.empty()) continue;
      const std::vector<int> units = with_units(others, own);
      const auto imitation = solve(alone, units);
      if (!imitation || energy - imitation->gain > kCannotTell) continue;
      const auto tie = solve(library, units);
      if (tie && tie->usual) ties.push_back(*tie);
    }
  }
  return ties;
}

std::vector<std::string> names_of(const Candidate& candidate) {
  std::vector<std::string> names;
  for (const int e : candidate.effects)
    names.push_back(effect_catalogue()[static_cast<std::size_t>(e)].name);
  return names;
}

}  // namespace trammel
