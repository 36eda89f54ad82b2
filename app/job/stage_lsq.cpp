#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/job/stages.hpp"
#include "core/calibrate/lsq.hpp"
#include "core/measure/noise.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

Json complete_lsq(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of lsq");
  Fields f(file);
  const Json all = {{"parameters", f.choice("parameters", {"paper-18", "complete-21"}, "paper-18")},
                    {"epochs", f.choice("epochs", {"own", "shared"}, "own")},
                    {"solution", f.choice("solution", {"least-change", "basic"}, "least-change")},
                    {"drop_below", f.number("drop_below", 0.0)},
                    {"steps", f.integer("steps", 10)}};
  f.done();
  if (!(all["drop_below"].get<double>() >= 0)) {
    f.refuse("drop_below", "a share of a tolerance cannot be negative", "0 or more");
  }
  if (all["steps"].get<int>() < 1) f.refuse("steps", "the system is solved once at least");
  return all;
}

constexpr double kStill = 1e-6;  // tolerances: a further step changes nothing

/// Solves, linearises again at what was found, and solves for the rest: the first-order system of
/// the source overshoots where an error that it lacks (a drive's gain) drives parameters far from
/// nominal. Each change is from nominal; rank, words and uncertainty are those of the first system.
/// Where sources were dropped, or later epochs have columns of their own, the first step stands.
LsqResult identify(const Mechanism& mechanism, const std::vector<Reading>& rows,
                   const TrackerSigma& sigma, const LsqOptions& options, int steps) {
  LsqResult result = identify_linear(mechanism, rows, sigma, options);
  if (!result.epochs.empty() || result.rounds.size() > 1) return result;
  Mechanism at = mechanism;
  for (int step = 1; step < steps; ++step) {
    at.geometry = result.geometry;
    const LsqResult next = identify_linear(at, rows, sigma, options);
    double largest = 0;
    for (std::size_t k = 0; k < result.parameters.size(); ++k) {
      const double more = next.parameters[k].value;
      result.parameters[k].value += more;
      largest = std::max(largest, std::abs(more) / result.parameters[k].parameter.tolerance);
    }
    for (std::size_t k = 0; k < std::min(result.combinations.size(), next.combinations.size());
         ++k) {
      result.combinations[k].value += next.combinations[k].value;
    }
    result.geometry = next.geometry;
    result.weighted_rss = next.weighted_rss;
    result.sigma_ratio = next.sigma_ratio;
    if (largest < kStill) break;
  }
  return result;
}

LsqOptions options_of(const Json& p) {
  return {.complete = p["parameters"] == "complete-21",
          .shared_epochs = p["epochs"] == "shared",
          .basic_solution = p["solution"] == "basic",
          .drop_below = p["drop_below"].get<double>()};
}

const char* unit(bool is_angle) { return is_angle ? "deg" : "mm"; }
double shown(bool is_angle, double value) { return is_angle ? deg_from_rad(value) : value; }

/// A number stands only beside a parameter that is identified.
Json parameter_json(const LsqParameter& p) {
  const bool angle = p.parameter.is_angle;
  Json json = {{"name", p.parameter.name}, {"unit", unit(angle)}, {"identified", p.identified}};
  if (p.identified) {
    json["change"] = shown(angle, p.value);
    json["standard_uncertainty"] = shown(angle, p.standard_uncertainty);
  } else {
    json["why"] = p.dropped ? "dropped as small by repeated identification"
                            : "not identifiable by itself from these readings";
  }
  return json;
}

Json combination_json(const IdentifiedCombination& c) {
  return {{"name", c.name},
          {"unit", unit(c.is_angle)},
          {"value", shown(c.is_angle, c.value)},
          {"standard_uncertainty", shown(c.is_angle, c.standard_uncertainty)}};
}

Json rounds_json(const std::vector<LsqRound>& rounds) {
  Json json = Json::array();
  for (const LsqRound& r : rounds) {
    json.push_back({{"columns", r.columns},
                    {"rank", r.rank},
                    {"weighted_rss", r.weighted_rss},
                    {"dropped", r.dropped}});
  }
  return json;
}

Json details_of(const LsqResult& result, const NoiseLevel& noise) {
  const Identifiability& known = result.identifiability;
  const Observability& o = known.observability;
  Json details = {
      {"equations", result.n_equations},
      {"columns", known.singular.size()},
      {"rank", known.rank},
      {"rank_machine", known.rank_machine},
      {"rank_solved", result.rank},
      {"weighted_rss", result.weighted_rss},
      {"sigma_ratio", result.sigma_ratio},
      {"noise", noise.words},
      {"observability", {{"O1", o.O1}, {"O2", o.O2}, {"O3", o.O3}, {"O4", o.O4}, {"O5", o.O5}}}};
  for (const LsqParameter& p : result.parameters) {
    details["parameters"].push_back(parameter_json(p));
  }
  details["combinations"] = Json::array();
  for (const IdentifiedCombination& c : result.combinations) {
    details["combinations"].push_back(combination_json(c));
  }
  details["rounds"] = rounds_json(result.rounds);
  return details;
}

StageResult run_lsq(const Campaign& campaign, const Json& parameters) {
  const NoiseLevel noise = noise_level(campaign);
  const LsqResult result = identify(campaign.mechanism, identify_rows(campaign), noise.sigma,
                                    options_of(parameters), parameters["steps"].get<int>());
  StageResult out{.correction = GeometryCorrection{result.geometry},
                  .details = details_of(result, noise),
                  .words = result.words};
  for (const IdentifiedCombination& c : result.combinations) {
    out.words.push_back(
        fmt::format("{} = {:.4f} +- {:.4f} {} (k = 2)", c.name, shown(c.is_angle, c.value),
                    2 * shown(c.is_angle, c.standard_uncertainty), unit(c.is_angle)));
  }
  out.words.push_back(fmt::format(
      "residuals are {:.2f} times the noise: {}", result.sigma_ratio,
      result.sigma_ratio < 1.2 ? "constant parameters explain these readings"
                               : "something is there that constant parameters cannot explain"));
  return out;
}

}  // namespace

Stage lsq_stage() {
  return {.name = "lsq",
          .algorithm_version = 2,
          .what = "the paper's linear least squares on all readings, with its rank",
          .complete = complete_lsq,
          .run = run_lsq};
}

}  // namespace trammel::job
