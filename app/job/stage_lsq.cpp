#include <algorithm>
#include <cmath>

#include "app/job/identification.hpp"
#include "app/job/stages.hpp"
#include "core/calibrate/lsq.hpp"
#include "core/measure/noise.hpp"

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

/// Parameters that repeated identification dropped are not identified, whatever the readings tell.
void mark_dropped(const LsqResult& result, Json& details) {
  for (std::size_t k = 0; k < result.parameters.size(); ++k) {
    if (!result.parameters[k].dropped) continue;
    Json& p = details["parameters"][k];
    p = {{"name", p["name"]},
         {"unit", p["unit"]},
         {"identified", false},
         {"why", "dropped as small by repeated identification"}};
  }
}

StageResult run_lsq(const Campaign& campaign, const Json& parameters) {
  const NoiseLevel noise = noise_level(campaign);
  const LsqResult result = identify(campaign.mechanism, identify_rows(campaign), noise.sigma,
                                    options_of(parameters), parameters["steps"].get<int>());
  std::vector<ScaledParameter> names;
  Eigen::VectorXd values(static_cast<Eigen::Index>(result.parameters.size()));
  for (std::size_t k = 0; k < result.parameters.size(); ++k) {
    names.push_back(result.parameters[k].parameter);
    values[static_cast<Eigen::Index>(k)] = result.parameters[k].value;
  }
  const auto is_geometry = [](const LsqParameter& p) { return p.epoch == 1; };
  const Identification found{
      .known = result.identifiability,
      .parameters = names,
      .values = values,
      .covariance = result.covariance,
      .n_geometry = static_cast<std::size_t>(std::ranges::count_if(result.parameters, is_geometry)),
      .goodness = goodness(result.weighted_rss, result.n_equations - result.rank,
                           noise.degrees_of_freedom)};
  StageResult out{.correction = GeometryCorrection{result.geometry},
                  .details = identification_json(found),
                  .words = identification_words(found)};
  out.details["equations"] = result.n_equations;
  out.details["rank_solved"] = result.rank;
  out.details["weighted_rss"] = result.weighted_rss;
  out.details["noise"] = noise.words;
  out.details["rounds"] = rounds_json(result.rounds);
  mark_dropped(result, out.details);
  return out;
}

}  // namespace

Stage lsq_stage() {
  return {.name = "lsq",
          .algorithm_version = 3,
          .what = "the paper's linear least squares on all readings, with its rank",
          .complete = complete_lsq,
          .run = run_lsq};
}

}  // namespace trammel::job
