#include "core/diagnose/look_alikes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <vector>

#include "core/model/effect.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

/// Deviation at a reading per unit of parameter `k`, as an effect's basis has it.
using Basis = std::function<Deviation(const Reading&, const Moment&, int k)>;

struct Pretender {
  std::vector<std::string> effects;  // that it may be taken for
  std::string name, what, when;
  Basis basis;
  int columns = kChains;  // one a rail, of which some are chosen, or one value for all; 1: no rails
  double rarity = kEvidence20To1;  // 2 ln of how much rarer than the effect
  bool always = false;             // tested even where nothing tells it apart
  bool positive = false;           // its one column has no other sign
  bool law = false;         // a law of its own: told apart by doing far better, however alike
  ActiveEffect shape = {};  // with a name in the catalogue
};

Deviation along(int rail, double dl_mm) {
  Deviation d;
  d.dl_mm[rail] = dl_mm;
  return d;
}

// 2 ln 12. With kEvidence20To1 a tie: the likelihood of growth that lags, averaged over the lags
// that are tried, is more than 0.6 of that of growth which does not. Prompt growth seen at rho of
// 14 leaves it 0.5 and less (lags up to 16 min of 6 h can't be told from none), one that lags by
// that and is half hidden in the noise 0.8 and more.
constexpr double kPriceOfLag = 5.0;
constexpr double kLongestLagS = 6.5 * 3600;
constexpr double kSteadyK = 0.1;  // less is the last digit of a thermometer

std::string length(double mm) { return std::to_string(static_cast<int>(mm)) + " mm"; }

/// An effect of the catalogue that remembers, of these shapes.
ActiveEffect with_shapes(const char* name, std::initializer_list<double> shapes) {
  ActiveEffect idle{&find_effect(name), {}};
  idle.values = Eigen::VectorXd::Zero(std::ssize(idle.effect->parameters));
  Eigen::Index k = idle.values.size() - std::ssize(shapes);
  for (const double shape : shapes) idle.values[k++] = shape;
  return idle;
}

/// Of some effects it may be taken for.
Pretender memory(const ActiveEffect& shape, const History& history,
                 std::vector<std::string> effects, std::string what, std::string when) {
  return {.effects = std::move(effects),
          .name = shape.effect->name,
          .what = std::move(what),
          .when = std::move(when),
          .basis =
              [&history, shape](const Reading& r, Moment m, int k) {
                shape.effect->recall(m, shape.values, r.conditions, &history);
                return shape.effect->basis(m, k);
              },
          .rarity = kEvidence20To1 / 2,
          .law = true,
          .shape = shape};
}

/// Friction that remembers the path: play operators, and what a move leaves until a longer one.
void add_memory(const ResidualSpace& space, const History& history, std::vector<Pretender>& kinds) {
  // one play, or as many of neighbouring octaves with one weight: a hysteresis of some width
  for (const double least : History::kRadiiMm) {
    for (const double largest : History::kRadiiMm) {
      if (largest < least) continue;
      kinds.push_back(
          memory(with_shapes("hysteresis", {least, largest}), history, {"backlash", "move_memory"},
                 drives_name(*space.machine.kind) + " whose friction remembers the path",
                 largest == least ? "play of " + length(least)
                                  : "plays of " + length(least) + " to " + length(largest)));
    }
  }
  for (const double d : {1, 2, 3, 5, 8, 12, 20, 30}) {
    kinds.push_back(memory(with_shapes("move_memory", {d}), history, {"backlash", "hysteresis"},
                           drives_name(*space.machine.kind) + " that remember the last move",
                           "decaying over " + length(d)));
  }
}

/// What goes with temperature or time in a way that growth and drift do too.
void add_slow(const ResidualSpace& space, const History& history, std::vector<Pretender>& kinds) {
  const std::vector<Reading>& readings = space.readings;
  const bool timed = std::ranges::all_of(
      readings, [](const Reading& r) { return r.conditions.time_s.has_value(); });
  if (!timed) return;
  const double first_s = *std::ranges::min(readings, {}, [](const Reading& r) {
                            return *r.conditions.time_s;
                          }).conditions.time_s;
  for (const int within_min : {5, 10, 15, 20, 30}) {
    kinds.push_back({.effects = {"thermal_growth", "tracker_drift", "lagged_growth"},
                     .name = "settling",
                     .what = drives_name(*space.machine.kind) + " that settle after the start",
                     .when = "within " + std::to_string(within_min) + " min",
                     .basis = [=](const Reading& r, const Moment&, int k) {
                       const double since_s = *r.conditions.time_s - first_s;
                       return along(k, std::exp(-since_s / (60 * within_min)));
                     }});
  }
  const auto recorded = [](const Reading& r) {
    return r.conditions.temp_degc.has_value() && r.conditions.time_s.has_value();
  };
  if (!std::ranges::all_of(readings, recorded)) return;
  const auto [coldest, warmest] =
      std::ranges::minmax(readings, {}, [](const Reading& r) { return *r.conditions.temp_degc; });
  if (*warmest.conditions.temp_degc - *coldest.conditions.temp_degc < kSteadyK) return;
  for (int k = 2; History::lag_s(k) < kLongestLagS; ++k) {  // a minute, half an octave each
    const double lag_s = History::lag_s(k);
    const std::string late =
        std::to_string(static_cast<int>(std::lround(lag_s / 60))) + " min late";
    kinds.push_back(
        memory(with_shapes("lagged_growth", {lag_s}), history, {"thermal_growth", "tracker_drift"},
               drives_name(*space.machine.kind) + " that follow the thermometer", late));
    // a small growth that lags is as good as one that does not: a tie until the lag shows
    kinds.back().rarity = kPriceOfLag;
    kinds.back().always = true;
    kinds.push_back({.effects = {"thermal_growth", "lagged_growth", "tracker_drift", "lead_scale"},
                     .name = "delay",
                     .what = kinds.back().what,
                     .when = late + ", by a delay",
                     .basis =
                         [&history, lag_s](const Reading& r, const Moment& m, int rail) {
                           const double degc = history.delayed_degc(r.conditions, lag_s);
                           return along(rail, m.l_mm[rail] * (degc - kReferenceTemperatureDegc));
                         },
                     .law = true});
  }
}

/// A measuring plane tilted by t: lengths along azimuth a shrink by 1 - cos t = m.
void add_tilts(std::vector<Pretender>& kinds) {
  constexpr int kAzimuths = 36;  // half a turn; 2.5 deg off the nearest loses 0.2 % of the signal
  for (int k = 0; k < kAzimuths; ++k) {
    const double a = kPi * k / kAzimuths;
    char when[48];
    std::snprintf(when, sizeof when, "along %.0f deg", deg_from_rad(a));
    kinds.push_back({.effects = {"lead_scale", "tracker_scale"},
                     .name = "plane_tilt",
                     .what = "the measuring plane is tilted: lengths shrink",
                     .when = when,
                     .basis =
                         [a](const Reading&, const Moment& m, int) {
                           const double c = std::cos(a), s = std::sin(a);
                           const double along_a = c * m.pose.x_mm + s * m.pose.y_mm;
                           Deviation d;
                           d.dX = {-along_a * c, -along_a * s, 0};
                           return d;
                         },
                     .columns = 1,
                     .rarity = 0,
                     .always = true,
                     .positive = true});
  }
}

std::vector<Pretender> kinds_for(const ResidualSpace& space, const History& history) {
  std::vector<Pretender> kinds = {
      {.effects = {"backlash", "move_memory", "hysteresis"},
       .name = "lost motion",
       .what = drives_name(*space.machine.kind) + " that lose motion",
       .when = "in proportion to the last move",
       .basis = [](const Reading&, const Moment& m, int k) { return along(k, m.travel_mm[k]); }},
      // five sixths of it are a lead error, to any test that looks at what such an error leaves
      {.effects = {"lead_scale", "lead_curvature"},
       .name = "cubic lead",
       .what = drives_name(*space.machine.kind) + " that err",
       .when = "with the cube of travel",
       .basis = [](const Reading&, const Moment& m, int k) {
         return along(k, m.s_mm[k] * m.s_mm[k] * m.s_mm[k]);
       }}};
  add_memory(space, history, kinds);
  add_slow(space, history, kinds);
  add_tilts(kinds);
  std::erase_if(kinds, [&](const Pretender& kind) {
    return std::ranges::any_of(space.remembered, [&](const ActiveEffect& known) {
      return known.effect == kind.shape.effect;
    });
  });
  return kinds;
}

/// Sets of effects of `best` that a kind may stand for: each alone, and all of them.
std::vector<std::vector<int>> taken_for(const Pretender& kind, const Candidate& best) {
  std::vector<std::vector<int>> sets;
  std::vector<int> all;
  for (const int effect : best.effects) {
    const std::string& name = effect_catalogue()[static_cast<std::size_t>(effect)].name;
    if (std::ranges::find(kind.effects, name) == kind.effects.end()) continue;
    sets.push_back({effect});
    all.push_back(effect);
  }
  if (all.size() > 1) sets.push_back(all);
  return sets;
}

/// Units of `best` with (`of_it`) or without the effects.
std::vector<int> units_of(const Library& library, const Candidate& best,
                          const std::vector<int>& effects, bool of_it) {
  std::vector<int> units;
  for (const int u : best.units) {
    const int effect = library.units[static_cast<std::size_t>(u)].effect;
    if ((std::ranges::find(effects, effect) != effects.end()) == of_it) units.push_back(u);
  }
  return units;
}

Eigen::MatrixXd signals_of(const Library& library, const std::vector<int>& units) {
  std::vector<int> columns;
  for (const int u : units) {
    const auto& own = library.units[static_cast<std::size_t>(u)].columns;
    columns.insert(columns.end(), own.begin(), own.end());
  }
  return library.signals(Eigen::all, columns);
}

/// What of the columns stands beside an orthonormal span.
Eigen::MatrixXd beside(const Eigen::MatrixXd& span, const Eigen::MatrixXd& columns) {
  return without(span, columns);
}

/// Effects of the best set, taken out: the span that they leave free, and what they explain there.
struct Setting {
  Eigen::MatrixXd kept;  // orthonormal: what stays named
  Eigen::MatrixXd span;  // of the effects, beside it
  Eigen::VectorXd seen;  // of the residual, in that span
  double price = 0;      // of the effects' units
};

Setting place_of(const ResidualSpace& space, const Library& library, const Candidate& best,
                 const std::vector<int>& effects) {
  const std::vector<int> others = units_of(library, best, effects, false);
  Setting place{
      .kept = orthonormal(space.project(signals_of(library, others))), .span = {}, .seen = {}};
  place.span = orthonormal(beside(
      place.kept, space.project(signals_of(library, units_of(library, best, effects, true)))));
  place.seen = within(place.span, space.residual);
  place.price = price_of(library, best.units) - price_of(library, others);
  return place;
}

/// Choices of rails: some of them with a value each, or all of them with one value (the last).
std::vector<Eigen::MatrixXd> choices_of(int columns) {
  const Eigen::MatrixXd each = Eigen::MatrixXd::Identity(columns, columns);
  std::vector<Eigen::MatrixXd> choices;
  for (unsigned choice = 1; choice < 1U << columns; ++choice) {
    std::vector<int> chosen;
    for (int k = 0; k < columns; ++k) {
      if ((choice >> k & 1U) != 0) chosen.push_back(k);
    }
    choices.emplace_back(each(Eigen::all, chosen));
  }
  if (columns > 1) choices.emplace_back(Eigen::MatrixXd::Ones(columns, 1));
  return choices;
}

/// The choice of rails that earns most in place of the effects; nothing where the readings can't
/// tell the two apart.
std::optional<LookAlike> best_rails(const ResidualSpace& space, const Setting& place,
                                    const Eigen::MatrixXd& columns, const Pretender& kind,
                                    const std::vector<int>& effects) {
  std::optional<LookAlike> found;
  for (const Eigen::MatrixXd& choice : choices_of(static_cast<int>(columns.cols()))) {
    const Eigen::MatrixXd own = beside(place.kept, product(columns, choice));
    if (kind.positive && own.col(0).dot(space.residual) < 0) continue;
    const Eigen::MatrixXd span = orthonormal(own);
    const Eigen::VectorXd seen = within(span, space.residual);
    // what either can't imitate of the other as fitted
    const double distinct =
        std::max(without(span, place.seen).squaredNorm(), without(place.span, seen).squaredNorm());
    const auto n = static_cast<double>(choice.cols());
    const double price =
        kPriceOfName + kPriceOfParameter + (n - 1) * (kPriceOfFurther + 2 * std::log(kChains));
    const double evidence =
        seen.squaredNorm() - price - kind.rarity - (place.seen.squaredNorm() - place.price);
    // Nearly the same signal is no rival; one with a name that does far better is what is there.
    const double share = kind.law && evidence > kEvidence20To1 ? 0 : kSameSignal;
    const double apart = std::max(kTellApart, share * place.seen.squaredNorm());
    if ((distinct < apart && !kind.always) || (found && evidence <= found->evidence)) continue;
    found = LookAlike{
        kind.rarity < kEvidence20To1 ? kind.name : "unnamed: " + kind.what + ", " + kind.when,
        {kind.what, kind.when, chi2_tail(seen.squaredNorm(), n), seen.squaredNorm(),
         static_cast<int>(choice.cols())},
        evidence,
        kind.shape,
        effects,
        {}};
    for (Eigen::Index c = 0; c < choice.cols(); ++c) {
      found->terms.emplace_back([basis = kind.basis, rails = Eigen::VectorXd(choice.col(c))](
                                    const Reading& r, const Moment& m) {
        Deviation sum;
        for (int k = 0; k < rails.size(); ++k) {
          if (rails[k] != 0) sum += basis(r, m, k);
        }
        return sum;
      });
    }
  }
  return found;
}

/// A kind at all of its scales (radius, length, time, azimuth), each as likely as the others
/// beforehand: its evidence is that of their mean likelihood, 2 ln(sum exp(e / 2) / scales).
std::optional<LookAlike> over_scales(const std::vector<LookAlike>& at_scales, std::size_t scales) {
  if (at_scales.empty()) return std::nullopt;
  LookAlike best = *std::ranges::max_element(at_scales, {}, &LookAlike::evidence);
  double sum = 0;
  for (const LookAlike& alike : at_scales) sum += std::exp((alike.evidence - best.evidence) / 2);
  best.evidence += 2 * std::log(sum / static_cast<double>(scales));
  return best;
}

}  // namespace

std::vector<LookAlike> look_alikes(const ResidualSpace& space, const Library& library,
                                   const Candidate& best, const History& history) {
  const std::vector<Pretender> kinds = kinds_for(space, history);
  std::map<std::vector<int>, Setting> places;
  std::map<std::string, std::size_t> scales;
  std::map<std::pair<std::string, std::vector<int>>, std::vector<LookAlike>> at_scales;
  for (const Pretender& kind : kinds) {
    ++scales[kind.name];
    const auto sets = taken_for(kind, best);
    if (sets.empty()) continue;
    Eigen::MatrixXd columns(space.rows(), kind.columns);
    for (int k = 0; k < kind.columns; ++k) {
      columns.col(k) = whitened_signal(
          space, [&](const Reading& r, const Moment& m) { return kind.basis(r, m, k); });
    }
    columns = space.project(columns);
    for (const std::vector<int>& effects : sets) {
      if (!places.contains(effects)) places[effects] = place_of(space, library, best, effects);
      if (auto alike = best_rails(space, places[effects], columns, kind, effects))
        at_scales[{kind.name, effects}].push_back(*std::move(alike));
    }
  }
  std::map<std::string, LookAlike> of_kind;
  for (const auto& [key, alikes] : at_scales) {
    const auto alike = over_scales(alikes, scales[key.first]);
    if (!alike || alike->evidence <= -kEvidence20To1) continue;
    const auto known = of_kind.try_emplace(key.first, *alike).first;
    if (alike->evidence > known->second.evidence) known->second = *alike;
  }
  std::vector<LookAlike> found;
  for (const auto& [name, alike] : of_kind) found.push_back(alike);
  std::ranges::stable_sort(found, std::greater{}, &LookAlike::evidence);
  return found;
}

}  // namespace trammel
