#include "tests/study/judge.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/calibrate/geometry_fit.hpp"
#include "core/diagnose/selection.hpp"
#include "core/simulate/virtual_robot.hpp"
#include "core/units.hpp"

namespace trammel::tests {

namespace {

std::vector<Reading> fitted(const std::vector<Reading>& readings) {
  std::vector<Reading> of_set;
  std::copy_if(readings.begin(), readings.end(), std::back_inserter(of_set),
               [](const Reading& r) { return r.set == ReadingSet::identify; });
  return of_set;
}

/// chi^2 of noise-free readings: what the base leaves, and what the best set with other names
/// leaves of that (none is a superset).
struct Left {
  double base = 0, rival = 0;
};
Left left_of(const HiddenCase& c) {
  const TrackerSigma sigma{c.truth.tracker.sigma_xy_mm, c.truth.tracker.sigma_phi_rad};
  const std::vector<Reading> readings = fitted(c.still);
  const ResidualSpace space = residual_space(
      fit_geometry(nominal_model(c.campaign.machine), readings, sigma), readings, sigma);
  const Library library = make_library(space);
  double least = space.residual.squaredNorm();
  for (const Candidate& candidate :
       search(library, static_cast<int>(std::max<std::size_t>(1, c.hidden.size())))) {
    std::vector<std::string> names = names_of(candidate);
    std::sort(names.begin(), names.end());
    if (std::includes(names.begin(), names.end(), c.hidden.begin(), c.hidden.end())) continue;
    least = std::min(least, space.residual.squaredNorm() - candidate.gain);
  }
  return {space.residual.squaredNorm(), least};
}

Expected expected_of(const HiddenCase& c, double margin, double left) {
  if (c.hidden.empty()) return c.bad.empty() ? Expected::nothing : Expected::outliers;
  if (!c.in_catalogue && left < kVisible) return Expected::hardly_visible;
  if (!c.in_catalogue) return margin > kFar ? Expected::unexplained : Expected::not_confident;
  return margin > kClear ? Expected::named : Expected::among;
}

std::vector<std::string> names_said(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const NamedEffect& e : d.effects) names.push_back(e.name);
  std::sort(names.begin(), names.end());
  return names;
}

bool among_candidates(const HiddenCase& c, const Diagnosis& d) {
  std::vector<std::string> candidates = names_said(d);
  for (const Rival& r : d.rivals)
    candidates.insert(candidates.end(), r.names.begin(), r.names.end());
  return std::all_of(c.hidden.begin(), c.hidden.end(), [&](const std::string& name) {
    return std::count(candidates.begin(), candidates.end(), name) > 0;
  });
}

bool all_outliers_named(const HiddenCase& c, const Diagnosis& d) {
  std::vector<int> bad;
  for (const std::size_t at : c.bad) bad.push_back(c.campaign.readings[at].seq);
  std::sort(bad.begin(), bad.end());
  return d.effects.size() == 1 && d.effects.front().seqs == bad;
}

/// All of it, or the part that is all that shows.
bool is_part(const std::vector<std::string>& said, const std::vector<std::string>& hidden) {
  return !said.empty() && std::includes(hidden.begin(), hidden.end(), said.begin(), said.end());
}

/// A pure delay behind the thermometer is a growth that lags, by another law.
bool is_its_kin(const std::vector<std::string>& said, const std::vector<std::string>& hidden) {
  return hidden == std::vector<std::string>{"thermal_lag"} &&
         said == std::vector<std::string>{"lagged_growth"};
}

Judgement::Mark mark_of(const HiddenCase& c, const Diagnosis& d, Expected expected) {
  using Mark = Judgement::Mark;
  const bool confident = d.verdict == Verdict::explained;
  const bool silent = d.verdict == Verdict::nothing_missing;
  const auto right_or = [&](bool right) {
    return right ? Mark::right : confident || silent ? Mark::wrong : Mark::abstained;
  };
  switch (expected) {
    case Expected::nothing:
      return silent ? Mark::right : confident ? Mark::wrong : Mark::abstained;
    case Expected::outliers:
      return right_or(confident && all_outliers_named(c, d));
    case Expected::named:
      return right_or(confident && names_said(d) == c.hidden);
    case Expected::among:
      return right_or((confident && is_part(names_said(d), c.hidden)) ||
                      (d.verdict == Verdict::ambiguous && among_candidates(c, d)));
    case Expected::unexplained:
      return right_or(d.verdict == Verdict::unexplained || is_its_kin(names_said(d), c.hidden));
    case Expected::hardly_visible:
      return confident && !is_its_kin(names_said(d), c.hidden) ? Mark::wrong : Mark::right;
    case Expected::not_confident:
      return right_or((!confident && !silent) || is_its_kin(names_said(d), c.hidden));
  }
  return Mark::abstained;
}

void compare_values(const HiddenCase& c, const Diagnosis& d, Judgement& judged) {
  auto hidden = parameters_of(c);
  std::erase_if(hidden, [](const auto& entry) { return entry.second == 0; });
  std::map<std::string, const NamedParameter*> told;
  for (const NamedEffect& e : d.effects) {
    for (const NamedParameter& p : e.parameters) told[e.name + " " + p.name] = &p;
  }
  for (const auto& [name, value] : hidden) {
    ++judged.values;
    const auto at = told.find(name);
    if (at == told.end()) continue;
    judged.values_good += std::abs(at->second->value - value) <= 4 * at->second->std;
  }
}

/// Hidden values and reported ones, against two standard deviations: of named effects, and of those
/// that may also hold (0 +- theirs). What was hidden and is in neither is missed.
void cover(const HiddenCase& c, const Diagnosis& d, Judgement& judged) {
  auto hidden = parameters_of(c);
  std::map<std::string, NamedParameter> told;
  for (const NamedEffect& e : d.effects) {
    for (const NamedParameter& p : e.parameters) told[e.name + " " + p.name] = p;
  }
  for (const Possible& e : d.may_also_hold) {
    for (const NamedParameter& p : e.parameters) {
      if (hidden[e.name + " " + p.name] != 0) told[e.name + " " + p.name] = p;
    }
  }
  for (const auto& [name, value] : hidden) {
    const auto at = told.find(name);
    if (at == told.end() ? value == 0 : at->second.std == 0) continue;
    ++judged.counted;
    const double std = at == told.end() ? 0 : at->second.std;
    const double off = at == told.end() ? value : at->second.value - value;
    if (std::abs(off) <= 2 * std) {
      ++judged.covered;
      continue;
    }
    char text[96];
    std::snprintf(text, sizeof text, "; %s %+.3g +- %.3g off by %.1f", name.c_str(), value, std,
                  std > 0 ? std::abs(off) / std : INFINITY);
    judged.missed += text;
  }
}

/// rms over x and y, at poses no step has seen, of predicted minus true pose.
double unseen_rms_mm(const HiddenCase& c, const Diagnosis& d) {
  double sum = 0, count = 0;
  for (const Reading& still : c.still) {
    if (still.set != ReadingSet::validate) continue;
    const Prediction at = predict(d.fit.model, still.conditions);
    if (!at.ok()) return INFINITY;
    sum += (at.pose.vector() - still.measured->vector()).head<2>().squaredNorm();
    count += 2;
  }
  return std::sqrt(sum / count);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& n : names) text += (text.empty() ? "" : "+") + n;
  return text.empty() ? "-" : text;
}

}  // namespace

Judgement judge(const HiddenCase& c, const Diagnosis& d) {
  Judgement judged;
  const Left left = left_of(c);
  judged.margin = left.rival;
  judged.expected = expected_of(c, left.rival, left.base);
  judged.verdict = d.verdict;
  judged.mark = mark_of(c, d, judged.expected);
  judged.names_right = names_said(d) == c.hidden || (c.hidden.empty() && all_outliers_named(c, d));
  if (!c.hidden.empty() && c.in_catalogue &&
      (d.verdict == Verdict::explained || d.verdict == Verdict::ambiguous))
    cover(c, d, judged);
  if (judged.right() && d.verdict == Verdict::explained && !c.hidden.empty()) {
    compare_values(c, d, judged);
    judged.unseen_rms_mm = unseen_rms_mm(c, d);
    judged.closed = judged.unseen_rms_mm <= 0.5 * c.truth.tracker.sigma_xy_mm;
  }
  return judged;
}

Round judge_round(const HiddenCase& c, const Diagnosis& first, const Diagnosis& second) {
  const auto sorted = [](std::vector<std::string> names) {
    std::ranges::sort(names);
    return names;
  };
  std::vector<std::vector<std::string>> held = {names_said(second)};
  for (const Rival& r : second.rivals) held.push_back(sorted(r.names));
  const auto holds = [&](const std::vector<std::string>& set) {
    return second.verdict == Verdict::unexplained || std::ranges::find(held, set) != held.end();
  };
  Round round;
  for (const Rival& r : first.rivals) {
    std::string rival = " from";
    for (const std::string& name : r.names) rival += (name == r.names.front() ? " " : " + ") + name;
    const bool hopeless = std::ranges::any_of(
        first.next.undecided, [&](const Undecided& u) { return u.what.ends_with(rival); });
    if (hopeless || r.names.front().starts_with("unnamed")) continue;
    ++round.ties;
    round.decided += !(holds(names_said(first)) && holds(sorted(r.names)));
  }
  round.asked = round.ties > 0;
  round.kept = round.ties > 0 && second.verdict != Verdict::unexplained &&
               std::ranges::find(held, c.hidden) != held.end();
  return round;
}

std::string in_words(const HiddenCase& c, const Diagnosis& d, const Judgement& judged) {
  std::string line = to_string(d.verdict) + " " + joined(names_said(d));
  for (const Rival& r : d.rivals) line += " | " + joined(r.names);
  if (d.verdict == Verdict::unexplained && !d.structure.empty())
    line += " @ " + d.structure[0].where + ", " + d.structure[0].when;
  if (!judged.right()) {
    char text[64];
    std::snprintf(text, sizeof text, ", margin %.0f", judged.margin);
    line += "; hidden " + joined(c.hidden) + text;
  }
  if (judged.unseen_rms_mm > 0 && !judged.closed) {
    char text[64];
    std::snprintf(text, sizeof text, ", gap open by %.2f sigma",
                  judged.unseen_rms_mm / c.truth.tracker.sigma_xy_mm);
    line += text;
  }
  return line + judged.missed;
}

void Tally::add(const Judgement& j) {
  ++cases;
  switch (j.verdict) {
    case Verdict::nothing_missing:
      ++silent;
      break;
    case Verdict::unexplained:
      ++unexplained;
      break;
    case Verdict::ambiguous:
      ++ambiguous;
      break;
    case Verdict::explained:
      ++(j.names_right ? named : wrong);
      break;
  }
  right += j.mark == Judgement::Mark::right;
  abstained += j.mark == Judgement::Mark::abstained;
  values += j.values;
  values_good += j.values_good;
  explained += j.values > 0;
  closed += j.closed;
  counted += j.counted;
  covered += j.covered;
}

void Tally::add(const Tally& o) {
  cases += o.cases;
  named += o.named;
  ambiguous += o.ambiguous;
  silent += o.silent;
  unexplained += o.unexplained;
  wrong += o.wrong;
  right += o.right;
  abstained += o.abstained;
  values += o.values;
  values_good += o.values_good;
  explained += o.explained;
  closed += o.closed;
  counted += o.counted;
  covered += o.covered;
}

}  // namespace trammel::tests
