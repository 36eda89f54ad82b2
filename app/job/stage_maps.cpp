#include <fmt/format.h>

#include <cmath>

#include "app/job/stages.hpp"
#include "app/terminal/counted.hpp"
#include "core/judge/deviation.hpp"

namespace trammel::job {

namespace {

Json complete_idw(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of idw");
  Fields f(file);
  const Json all = {{"power", f.number("power", 2.0)},
                    {"neighbours", f.integer("neighbours", 0)},
                    {"tune", f.boolean("tune", false)},
                    {"epochs", f.choice("epochs", {"auto", "own", "shared"}, "auto")}};
  f.done();
  // d^-20 of places a thousandth of a nanometre apart and of 100 m are numbers still.
  require_within(f, all, "power", 1e-3, 20, "a power: 2 is the paper's");
  require_within(f, all, "neighbours", 0, 1e9, "a count: 0 for all samples");
  return all;
}

Json complete_rbf(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of rbf");
  Fields f(file);
  const Json all = {{"neurons", f.integer("neurons", 50)},
                    {"seed", f.integer("seed", 1)},
                    {"relative_ridge", f.number("relative_ridge", 1e-8)},
                    {"sigma_mm", f.number("sigma_mm", 0.0)},
                    {"smooth", f.boolean("smooth", false)},
                    {"epochs", f.choice("epochs", {"auto", "own", "shared"}, "auto")}};
  f.done();
  require_within(f, all, "seed", 0, 1e9, "a seed");
  require_within(f, all, "neurons", 1, 1e9, "a count: 50 is the paper's");
  // Below 1e-14 of the mean diagonal a ridge is rounding, and holds no singular system.
  require_within(f, all, "relative_ridge", 1e-14, 1e6, "a ridge of the weights");
  // A neuron narrower than a hundredth of a millimetre is met by no other place.
  if (all["sigma_mm"] != 0.0)
    require_within(f, all, "sigma_mm", 0.01, 1e6, "a spread, or 0 for leave-one-out");
  return all;
}

/// MAE, MSE over all three joints, and both R^2 per joint, of a map on the samples it learned.
Json training_scores(const JointMap& map, const std::vector<JointSample>& samples) {
  std::vector<double> all_p, all_m;
  Json joints = Json::array();
  for (int i = 0; i < kChains; ++i) {
    std::vector<double> predicted, measured;
    for (const JointSample& s : samples) {
      predicted.push_back(joint_error_at(map, {s.x_mm, s.y_mm})[i]);
      measured.push_back(s.error_mm[i]);
    }
    const FitScores scores = fit_scores(predicted, measured);
    joints.push_back({{"joint", i + 1},
                      {"mae_mm", scores.mae},
                      {"mse_mm2", scores.mse},
                      {"r2_pearson", optional_json(scores.r2_pearson)},
                      {"r2", optional_json(scores.r2)}});
    all_p.insert(all_p.end(), predicted.begin(), predicted.end());
    all_m.insert(all_m.end(), measured.begin(), measured.end());
  }
  const FitScores all = fit_scores(all_p, all_m);
  return {{"in_sample", true},           {"mae_mm", all.mae},
          {"mse_mm2", all.mse},          {"r2_pearson", optional_json(all.r2_pearson)},
          {"r2", optional_json(all.r2)}, {"joints", joints}};
}

constexpr std::size_t kMostIdwSamples = 20000;  // every query looks at every sample

StageResult run_idw(const Campaign& campaign, const Json& p) {
  StageResult out;
  const MapRows from = map_rows(campaign, p, out);
  const auto samples = joint_samples(campaign.machine, from.rows);
  if (samples.size() > kMostIdwSamples) {
    throw InputError({.what = "there are too many readings for inverse distance weighting",
                      .got = std::to_string(samples.size()),
                      .expected = "at most " + std::to_string(kMostIdwSamples),
                      .hint = "rbf and geometry take any number; or name fewer sessions"});
  }
  IdwOptions options{.power = p["power"].get<double>(), .neighbours = p["neighbours"].get<int>()};
  if (p["tune"].get<bool>()) options = tune_idw(samples);
  const IdwMap map = fit_idw(samples, options);
  const bool each_alone = samples.size() == map.x_mm.size();
  out.correction = MapCorrection{map, from.shifts};
  out.details = {{"samples", samples.size()},
                 {"places", map.x_mm.size()},
                 {"power", options.power},
                 {"neighbours", options.neighbours}};
  out.words.push_back(fmt::format(
      "{} in {}; in-sample errors are {}, and say nothing of the map "
      "between them",
      terminal::counted(samples.size(), "reading"), terminal::counted(map.x_mm.size(), "place"),
      each_alone ? "zero by construction" : "the scatter in each place"));
  return out;
}

double least_loo(const RbfTraining& training) {
  double least = INFINITY;
  for (const SpreadTrial& t : training.trials) least = std::min(least, t.loo_rms_mm);
  return least;
}

/// As asked for; smoothed: a neuron on every sample, ridge and spread both by leave-one-out.
RbfTraining train(const std::vector<JointSample>& samples, const Json& p) {
  RbfOptions options{.neurons = p["neurons"].get<int>(),
                     .seed = p["seed"].get<std::uint64_t>(),
                     .relative_ridge = p["relative_ridge"].get<double>(),
                     .sigma_mm = p["sigma_mm"].get<double>()};
  if (!p["smooth"].get<bool>()) return train_rbf(samples, options);
  options.neurons = static_cast<int>(samples.size());
  options.sigma_mm = 0;
  RbfTraining best;
  for (const double ridge : {1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 1e-1}) {
    options.relative_ridge = ridge;
    RbfTraining trial = train_rbf(samples, options);
    if (best.trials.empty() || least_loo(trial) < least_loo(best)) best = std::move(trial);
  }
  return best;
}

StageResult run_rbf(const Campaign& campaign, const Json& p) {
  StageResult out;
  const MapRows from = map_rows(campaign, p, out);
  const auto samples = joint_samples(campaign.machine, from.rows);
  const RbfTraining training = train(samples, p);
  Json trials = Json::array();
  for (const SpreadTrial& t : training.trials) {
    trials.push_back({{"sigma_mm", t.sigma_mm}, {"loo_rms_mm", t.loo_rms_mm}});
  }
  const JointMap map = training.network;
  out.correction = MapCorrection{map, from.shifts};
  out.details = {{"samples", samples.size()},
                 {"neurons", training.network.cx_mm.size()},
                 {"sigma_mm", training.sigma_mm},
                 {"kmeans_iterations", training.kmeans_iterations},
                 {"trials", trials},
                 {"training", training_scores(map, samples)}};
  out.words.push_back(fmt::format(
      "{} neurons with the common spread {:.1f} mm{}", training.network.cx_mm.size(),
      training.sigma_mm, training.trials.empty() ? " as given" : ", chosen by leave-one-out"));
  if (training.at_grid_end) {
    out.words.push_back(
        "the best spread is at the end of the grid: the field is smoother or "
        "rougher than the grid covers");
  }
  return out;
}

}  // namespace

Stage idw_stage() {
  return {.name = "idw",
          .algorithm_version = 8,
          .what = "inverse distance weighting of joint errors",
          .complete = complete_idw,
          .run = run_idw,
          .serves = serves_measured};
}

Stage rbf_stage() {
  return {.name = "rbf",
          .algorithm_version = 8,
          .what = "a Gaussian network of joint errors",
          .complete = complete_rbf,
          .run = run_rbf,
          .serves = serves_measured};
}

}  // namespace trammel::job
