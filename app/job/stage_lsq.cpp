#include <fmt/format.h>

#include <algorithm>

#include "app/job/identification.hpp"
#include "app/job/stages.hpp"
#include "app/terminal/counted.hpp"
#include "core/calibrate/lsq.hpp"
#include "core/calibrate/simulation.hpp"
#include "core/measure/noise.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

Json complete_lsq(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of lsq");
  Fields f(file);
  const Json all = {{"parameters", f.choice("parameters", {"paper-18", "complete-21"}, "paper-18")},
                    {"epochs", f.choice("epochs", {"auto", "own", "shared"}, "auto")},
                    {"solution", f.choice("solution", {"least-change", "basic"}, "least-change")},
                    {"drop_below", f.number("drop_below", 0.0)},
                    {"attitude_weight", f.number("attitude_weight", 1.0)},
                    {"steps", f.integer("steps", 10)}};
  f.done();
  require_within(f, all, "drop_below", 0, 1e6, "a share of a tolerance");
  // Beyond these one coordinate alone is solved: the other's equations vanish beside rounding.
  require_within(f, all, "attitude_weight", 1e-6, 1e6,
                 "a weight: 1 for the tracker's sigmas as stated");
  require_within(f, all, "steps", 1, 1000, "how often the system is solved");
  return all;
}

LsqOptions options_of(const Json& p) {
  return {.complete = p["parameters"] == "complete-21",
          .basic_solution = p["solution"] == "basic",
          .drop_below = p["drop_below"].get<double>(),
          .attitude_weight = p["attitude_weight"].get<double>()};
}

Json rounds_json(const std::vector<LsqRound>& rounds) {
  Json json = Json::array();
  for (const LsqRound& r : rounds) {
    json.push_back(object_with("columns", r.columns, "rank", r.rank, "weighted_rss", r.weighted_rss,
                               "dropped", r.dropped));
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
         {"dropped", true},
         {"why", "dropped as small by repeated identification"}};
  }
}

/// What repeated identification left out, round by round.
void add_round_words(const LsqResult& result, std::vector<std::string>& words) {
  for (std::size_t k = 0; k + 1 < result.rounds.size(); ++k) {
    const LsqRound& next = result.rounds[k + 1];
    words.push_back(fmt::format("round {}: dropped as small {}; left: {} of rank {}", k + 1,
                                fmt::join(result.rounds[k].dropped, ", "),
                                terminal::counted(next.columns, "column"), next.rank));
  }
}

/// How attitude counts against position: where constants cannot explain the readings, it matters.
std::string weight_words(const NoiseLevel& noise, double attitude_weight) {
  return fmt::format(
      "weights: a residual of {:.4f} mm in x or y counts as much as one of {:.4f} deg in phi ({})",
      noise.sigma.xy_mm, deg_from_rad(noise.sigma.phi_rad) / attitude_weight,
      attitude_weight == 1 ? "the tracker's sigmas"
                           : fmt::format("phi's weight times {:g}", attitude_weight));
}

std::string residual_words(const LsqResult& result) {
  return fmt::format("residuals, rms: {:.2f} sigma in position, {:.2f} sigma in attitude",
                     result.position_rms_sigma, result.attitude_rms_sigma);
}

/// Figs. 7 and 8 in a sentence.
std::string simulation_words(const Correction& correction, const Machine& machine,
                             const std::vector<Reading>& rows) {
  const SimulationScore s = simulation_score(simulated_errors(correction, machine, rows));
  return fmt::format(
      "forward kinematics with these values against {}: mean position error "
      "{:.4f} mm measured, {:.4f} mm simulated; their difference {:.4f} mm",
      terminal::counted(s.left.n, "fitted reading"), s.measured.mean, s.simulated.mean,
      s.left.mean);
}

/// The identified robot; with the shifts of its later epochs where it has any.
Correction correction_of(const LsqResult& result, const Mechanism& mechanism) {
  if (result.epochs.empty()) return GeometryCorrection{result.geometry};
  RobotModel robot = nominal_model(mechanism);
  set_geometry(robot.machine, result.geometry);
  robot.epochs = result.epochs;
  return ModelCorrection{robot};
}

void serves_prr(const Machine& machine) {
  if (machine.kind->chain == &kPrrChain) return;
  throw InputError({.what = "lsq is the paper's least squares, of the 18 parameters of a 3-PRR",
                    .got = std::string(machine.kind->name),
                    .expected = "a campaign of a 3-PRR",
                    .hint = "`trammel calibrate geometry` fits every kind of machine"});
}

StageResult run_lsq(const Campaign& campaign, const Json& parameters) {
  serves_prr(campaign.machine);
  const NoiseLevel noise = noise_level(campaign);
  const LsqOptions options = options_of(parameters);
  std::vector<std::string> epoch_words;
  const std::vector<Reading> rows =
      with_epochs(identify_rows(campaign), campaign.machine,
                  parameters["epochs"].get<std::string>(), epoch_words);
  const LsqResult result = identify_repeated(mechanism_of(campaign.machine), rows, noise.sigma,
                                             options, parameters["steps"].get<int>());
  std::vector<ScaledParameter> names;
  for (const LsqParameter& p : result.parameters) names.push_back(p.parameter);
  const auto is_geometry = [](const LsqParameter& p) { return p.epoch == 1; };
  const Identification found{
      .known = result.identifiability,
      .parameters = names,
      .values = result.values(),
      .covariance = result.covariance,
      .n_geometry = static_cast<std::size_t>(std::ranges::count_if(result.parameters, is_geometry)),
      .goodness =
          goodness(result.chi2, result.n_equations - result.rank, noise.degrees_of_freedom)};
  IdentificationReport told = identification_report(found);
  StageResult out{.correction = correction_of(result, mechanism_of(campaign.machine)),
                  .details = std::move(told.details),
                  .words = std::move(told.words)};
  out.details["equations"] = result.n_equations;
  out.details["rank_solved"] = result.rank;
  out.details["weighted_rss"] = result.weighted_rss;
  out.details["steps"] = result.steps;
  out.details["position_rms_sigma"] = result.position_rms_sigma;
  out.details["attitude_rms_sigma"] = result.attitude_rms_sigma;
  out.details["sigma_xy_mm"] = noise.sigma.xy_mm;
  out.details["sigma_phi_deg"] = deg_from_rad(noise.sigma.phi_rad);
  out.details["noise"] = noise.words;
  out.details["rounds"] = rounds_json(result.rounds);
  mark_dropped(result, out.details);
  add_round_words(result, out.words);
  out.words.insert(out.words.end(), epoch_words.begin(), epoch_words.end());
  out.words.push_back(weight_words(noise, options.attitude_weight));
  out.words.push_back(residual_words(result));
  out.words.push_back(simulation_words(out.correction, campaign.machine, rows));
  return out;
}

}  // namespace

Stage lsq_stage() {
  return {.name = "lsq",
          .algorithm_version = 10,
          .what = "the paper's linear least squares on all readings, with its rank",
          .complete = complete_lsq,
          .run = run_lsq,
          .serves = serves_prr};
}

}  // namespace trammel::job
