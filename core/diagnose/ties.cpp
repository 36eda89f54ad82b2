#include "core/diagnose/ties.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear/decompositions.hpp"

namespace trammel {

namespace {

const Effect& effect_at(int place) { return effect_catalogue()[static_cast<std::size_t>(place)]; }

std::string joined(const std::vector<std::string>& names, const char* with = " + ") {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : with) + n;
  return text;
}

std::string described(const Shape& shape) {
  return shape.when == "all" ? shape.where : shape.where + ", " + shape.when;
}

/// The candidate's parameters, of all its effects or of those `wanted`; values as fitted, or their
/// usual size.
template <typename Wanted>
std::vector<Tie::Term> terms_of(const Library& library, const Candidate& candidate, bool fitted,
                                Wanted wanted) {
  std::vector<Tie::Term> terms;
  Eigen::Index first = 0;
  for (const int u : candidate.units) {
    const Unit& unit = library.units[static_cast<std::size_t>(u)];
    for (std::size_t i = 0; i < unit.parameters.size() && wanted(unit.effect); ++i) {
      const int k = unit.parameters[i];
      const double value = candidate.values[first + static_cast<Eigen::Index>(unit.column_at(i))];
      const double usual = effect_at(unit.effect).parameters[static_cast<std::size_t>(k)].usual_max;
      terms.push_back(effect_term(unit.effect, k, fitted ? value : usual));
    }
    first += static_cast<Eigen::Index>(unit.columns.size());
  }
  return terms;
}

constexpr auto kAll = [](int) { return true; };

bool follows_direction(const std::vector<int>& effects) {
  return std::any_of(effects.begin(), effects.end(), [](int e) {
    const auto& needs = effect_at(e).needs;
    return std::find(needs.begin(), needs.end(), Need::direction) != needs.end();
  });
}

bool follows_direction(const Shape& shape) { return shape.when.starts_with("by "); }

constexpr const char* kOfTime[] = {"a shift at", "a wave of", "a trend of", "settling within"};

/// What happened at its time: no point measured later shows it again.
bool happened(const Shape& shape) {
  return std::any_of(std::begin(kOfTime), std::end(kOfTime),
                     [&](const char* word) { return shape.when.find(word) != std::string::npos; });
}

constexpr const char* kRailByRail = "each drive by itself under a linear scale or interferometer";

/// Another measurement, which shows an effect apart from all others. The tracker's own come first,
/// since no pose of the robot shows them; an effect that is not listed acts on rails.
struct Instrument {
  const char* effect;
  const char* measurement;
};
constexpr Instrument kInstruments[] = {
    {"tracker_scale", "a reference length (scale bar) with the tracker"},
    {"tracker_drift", "a fixed reflector on the base, again and again"},
    {"platform_load", "the same points with the payload taken off, or a known weight put on"},
    {"guide_bow", "the guides with a straightedge or alignment laser"},
    {"thermal_growth", "the same travel cold and warm under a linear scale"}};

std::string other_instruments(const std::vector<int>& effects) {
  for (const Instrument& i : kInstruments) {
    for (const int e : effects) {
      if (effect_at(e).name == i.effect) return i.measurement;
    }
  }
  return kRailByRail;
}

std::string other_instrument(const LookAlike& alike, const std::vector<int>& effects) {
  return alike.name == "plane_tilt"
             ? "the plane of measurement, by points of all nests, or level the frame"
             : other_instruments(effects);
}

std::string other_instrument(const Shape& shape) {
  return shape.where.starts_with("rail") ? kRailByRail
                                         : "a fixed reflector on the base, again and again";
}

/// Effects that only one of the two sets has.
std::vector<int> different(const Candidate& a, const Candidate& b) {
  std::vector<int> effects;
  std::set_symmetric_difference(a.effects.begin(), a.effects.end(), b.effects.begin(),
                                b.effects.end(), std::back_inserter(effects));
  return effects;
}

std::vector<int> united(const Candidate& a, const Candidate& b) {
  std::vector<int> effects;
  std::set_union(a.effects.begin(), a.effects.end(), b.effects.begin(), b.effects.end(),
                 std::back_inserter(effects));
  return effects;
}

/// What is left of the signal, over the readings there are, once base and columns are fitted to it.
double leftover(const ResidualSpace& space, const Tie& tie) {
  const auto column = [&](const Tie::Term& term) {
    return Eigen::VectorXd(term.value * whitened_signal(space, term.deviation));
  };
  Eigen::VectorXd signal = Eigen::VectorXd::Zero(space.rows());
  for (const Tie::Term& term : tie.signal) signal += column(term);
  Eigen::MatrixXd columns(space.rows(), static_cast<Eigen::Index>(tie.columns.size()));
  for (std::size_t k = 0; k < tie.columns.size(); ++k) {
    columns.col(static_cast<Eigen::Index>(k)) = column(tie.columns[k]);
  }
  signal = space.project(signal);
  const Eigen::MatrixXd U = orthonormal(space.project(columns));
  return without(U, signal).squaredNorm();
}

}  // namespace

Tie tie_between(const Library& library, const Candidate& best, const Candidate& rival,
                double lead) {
  Tie tie;
  tie.signal = terms_of(library, best, true, kAll);
  tie.columns = terms_of(library, rival, false, kAll);
  tie.effects = united(best, rival);
  tie.by_direction = follows_direction(tie.effects);
  tie.by_length = tie.by_direction && std::ranges::any_of(tie.effects, [](int e) {
                    return effect_at(e).recall != nullptr;
                  });
  tie.why = "tells " + joined(names_of(best)) + " from " + joined(names_of(rival));
  tie.instead = other_instruments(different(best, rival));
  tie.lead = lead;
  return tie;
}

Tie tie_with_unnamed(const ResidualSpace& space, const Library& library, const Candidate& best,
                     const Shape& shape, double lead) {
  std::vector<std::vector<int>> kept = {{}};
  for (const int effect : best.effects) {
    if (best.effects.size() < 2) break;
    kept.push_back(best.effects);
    std::erase(kept.back(), effect);
  }
  Tie closest;
  double least = 0;
  for (const std::vector<int>& others : kept) {
    const auto stays = [&others](int e) {
      return std::find(others.begin(), others.end(), e) != others.end();
    };
    Tie tie;
    tie.signal = terms_of(library, best, true, [&](int e) { return !stays(e); });
    tie.columns = terms_of(library, best, false, stays);
    for (const DeviationOf& term : shape.terms) tie.columns.push_back({term});
    const double energy = leftover(space, tie);
    if (!closest.signal.empty() && energy >= least) continue;
    closest = std::move(tie);
    least = energy;
  }
  closest.effects = best.effects;
  closest.by_direction = follows_direction(best.effects) || follows_direction(shape);
  closest.why = "tells " + joined(names_of(best)) + " from an unnamed error: " + described(shape);
  closest.instead = other_instrument(shape);
  closest.lead = lead;
  return closest;
}

Tie tie_with_look_alike(const Library& library, const Candidate& best, const LookAlike& alike) {
  const auto replaced = [&](int e) {
    return std::ranges::find(alike.effects, e) != alike.effects.end();
  };
  Tie tie;
  tie.signal = terms_of(library, best, true, replaced);
  tie.columns = terms_of(library, best, false, [&](int e) { return !replaced(e); });
  for (const DeviationOf& term : alike.terms) tie.columns.push_back({term});
  tie.effects = best.effects;
  tie.by_direction = tie.by_length = follows_direction(alike.effects);
  std::vector<std::string> names;
  for (const int e : alike.effects) names.push_back(effect_at(e).name);
  tie.why = "tells " + joined(names) + " from " + alike.name;
  tie.instead = other_instrument(alike, alike.effects);
  tie.lead = -alike.evidence;
  return tie;
}

std::optional<Tie> tie_with_memory(const Library& library, const Candidate& best,
                                   double length_mm) {
  LookAlike memory;
  memory.name = "move_memory";
  for (const int e : best.effects) {
    if (effect_at(e).name == "backlash") memory.effects.push_back(e);
  }
  if (memory.effects.empty()) return std::nullopt;
  for (int k = 0; k < kChains; ++k) {
    memory.terms.emplace_back([=](const Reading&, const Moment& m) {
      Deviation d;
      d.dl_mm[k] = -m.direction[k] * std::exp(-std::abs(m.travel_mm[k]) / length_mm);
      return d;
    });
  }
  return tie_with_look_alike(library, best, memory);
}

Tie tie_of_unexplained(const ResidualSpace& space, const Library& library, const Candidate& tried,
                       const Shape& shape) {
  const Eigen::VectorXd sizes =
      shortest_least_squares(space.project(shape.columns), space.residual);
  Tie tie;
  for (std::size_t k = 0; k < shape.terms.size() && !happened(shape); ++k) {
    tie.signal.push_back({shape.terms[k], sizes[static_cast<Eigen::Index>(k)]});
  }
  tie.columns = terms_of(library, tried, false, kAll);
  tie.effects = tried.effects;
  tie.by_direction = follows_direction(tie.effects) || follows_direction(shape);
  tie.why = "shows again " + described(shape);
  tie.instead = other_instrument(shape);
  return tie;
}

std::vector<Tie> blind_ties(const std::vector<AuditRow>& audit, const RobotModel& model) {
  constexpr double kShouldNotHide = 0.05;
  constexpr double kBlindShare = 1e-4;  // surviving share below which a design is blind
  std::vector<int> named;
  std::vector<Tie::Term> of_named;
  for (const ActiveEffect& active : model.effects) {
    named.push_back(static_cast<int>(active.effect - effect_catalogue().data()));
    for (std::size_t k = 0; k < active.effect->parameters.size(); ++k) {
      if (is_shape(*active.effect, static_cast<int>(k))) continue;
      of_named.push_back(
          effect_term(named.back(), static_cast<int>(k), active.effect->parameters[k].usual_max));
    }
  }
  std::vector<Tie> ties;
  for (std::size_t e = 0; e < audit.size(); ++e) {
    const Effect& effect = find_effect(audit[e].effect);
    const int place = static_cast<int>(&effect - effect_catalogue().data());
    if (std::find(named.begin(), named.end(), place) != named.end()) continue;
    if (effect.recall != nullptr) continue;  // what shows its relative without a memory shows it
    if (!audit[e].missing.empty() && effect.needs.front() != Need::direction) continue;
    const bool blind = !audit[e].smallest_visible || audit[e].surviving_share <= kBlindShare;
    if (!blind && !audit[e].only_unusual()) continue;
    for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
      if (!exists(effect, static_cast<int>(k), model.nominal)) continue;
      Tie tie;
      tie.signal = {effect_term(place, static_cast<int>(k),
                                (blind ? kShouldNotHide : 1) * effect.parameters[k].usual_max)};
      tie.columns = of_named;
      tie.effects = {place};
      tie.by_direction = follows_direction(tie.effects);
      tie.why = "makes " + effect.name + " visible";
      tie.instead = other_instruments({place});
      ties.push_back(std::move(tie));
    }
  }
  return ties;
}

std::vector<Considered> runners_up(const Candidate& best, const std::vector<Candidate>& all,
                                   std::size_t most) {
  std::vector<Considered> others;
  for (const Candidate& c : all) {
    if (others.size() == most) break;
    const double behind = best.score - c.score;
    const bool superset =
        std::includes(c.effects.begin(), c.effects.end(), best.effects.begin(), best.effects.end());
    if (superset || (c.usual && behind <= kEvidence20To1)) continue;
    others.push_back({names_of(c), c.parameters, behind, c.usual});
  }
  return others;
}

}  // namespace trammel
