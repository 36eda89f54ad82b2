// All methods on one baseline with the same folds; one is picked by a stated rule.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/job/held_out.hpp"
#include "app/job/stages.hpp"
#include "core/diagnose/diagnose.hpp"
#include "core/judge/before_after.hpp"
#include "core/judge/deviation.hpp"
#include "core/judge/floor.hpp"
#include "core/judge/verdict.hpp"
#include "core/measure/noise.hpp"
#include "core/plane/blocks.hpp"
#include "core/statistics/interval.hpp"
#include "core/statistics/summary.hpp"

namespace trammel::job {

namespace {

constexpr double kWorthNaming = 0.10;  // share of what is left
constexpr std::size_t kFewest = 10;
constexpr std::size_t kMost = 5000;  // tuning IDW looks at every pair, for every power, six times

/// A method, simplest first: the order breaks ties.
struct Candidate {
  std::string name;
  std::string stage;  // "" is the uncorrected robot
  Json parameters = Json::object();
};

/// A candidate's held-out errors, in the order of the readings.
struct Trial {
  Candidate candidate;
  std::vector<double> position_mm;
  Eigen::MatrixX3d left_mm;  // joint errors that are left
  double seconds = 0;
  std::string failed;  // why it could not run
};

Json complete_contest(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of the contest");
  Fields f(file);
  const Json all = {{"blocks", f.integer("blocks", 6)}, {"seed", f.integer("seed", 1)}};
  f.done();
  if (all["blocks"].get<int>() < 2) f.refuse("blocks", "a contest needs two blocks or more");
  if (all["seed"].get<int>() < 0) f.refuse("seed", "a seed is not negative");
  return all;
}

std::vector<Candidate> candidates(const Machine& machine, const std::vector<std::string>& effects) {
  std::vector<Candidate> all = {{"nominal", "", {}},
                                {"lsq", "lsq", {}},
                                {"geometry", "geometry", {}},
                                {"idw", "idw", {}},
                                {"idw local", "idw", {{"tune", true}}},
                                {"rbf", "rbf", {}},
                                {"rbf smooth", "rbf", {{"smooth", true}}},
                                {"gp", "gp", {}}};
  if (machine.kind->chain != &kPrrChain)
    std::erase_if(all, [](const Candidate& c) {
      return c.stage == "lsq";  // the paper's, of its kind of robot
    });
  if (!effects.empty()) all.push_back({"geometry + effects", "geometry", {{"effects", effects}}});
  all.push_back({"hybrid", "hybrid", {{"effects", effects}, {"map", "always"}}});
  for (Candidate& c : all) {
    if (c.parameters.is_null()) c.parameters = Json::object();
  }
  return all;
}

Correction fitted(const Candidate& candidate, const Campaign& training) {
  if (candidate.stage.empty()) return NominalCorrection{};
  const Stage& stage = find_stage(candidate.stage);
  return stage.run(training, stage.complete(candidate.parameters)).correction;
}

/// Fits without each block in turn and judges on it.
Trial held_out(const Candidate& candidate, const Campaign& campaign,
               const std::vector<Reading>& rows, const std::vector<int>& block) {
  const auto start = std::chrono::steady_clock::now();
  Trial trial{.candidate = candidate, .position_mm = {}, .left_mm = {}, .failed = {}};
  trial.position_mm.resize(rows.size());
  trial.left_mm.resize(static_cast<Eigen::Index>(rows.size()), 3);
  const std::vector<Pose> after =
      held_out_poses([&candidate](const Campaign& training) { return fitted(candidate, training); },
                     campaign, rows, block);
  const MachineSolver machine(campaign.machine);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const InverseResult l = machine.drives(after[k]), wanted = machine.drives(rows[k].target);
    if (!l.ok() || !wanted.ok()) throw InputError({.what = "a corrected target is out of reach"});
    trial.position_mm[k] = position_error_mm(after[k], rows[k].target);
    trial.left_mm.row(static_cast<Eigen::Index>(k)) = (l.l_mm - wanted.l_mm).transpose();
  }
  trial.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return trial;
}

Trial tried(const Candidate& candidate, const Campaign& campaign, const std::vector<Reading>& rows,
            const std::vector<int>& block) {
  try {
    return held_out(candidate, campaign, rows, block);
  } catch (const InputError& error) {
    Trial trial{.candidate = candidate, .position_mm = {}, .left_mm = {}, .failed = error.what()};
    return trial;
  }
}

/// Share of the variance of `y` that a straight line in `x` takes out, pooled over the joints.
double explained(const Eigen::MatrixX3d& y, const Eigen::MatrixX3d& x) {
  double total = 0, taken = 0;
  for (int i = 0; i < 3; ++i) {
    const Eigen::ArrayXd Y = y.col(i).array() - y.col(i).mean();
    const Eigen::ArrayXd X = x.col(i).array() - x.col(i).mean();
    total += Y.square().sum();
    const double S = X.square().sum();
    if (S > 0) taken += (X * Y).sum() * (X * Y).sum() / S;
  }
  return total > 0 ? taken / total : 0;
}

/// What the readings of a trial's rest depend on, beside place: {name, share}.
std::vector<std::pair<std::string, double>> dependences(const Trial& trial,
                                                        const std::vector<Reading>& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixX3d direction(n, 3), temperature(n, 3), time(n, 3), phi(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Reading& r = rows[static_cast<std::size_t>(k)];
    direction.row(k) = (r.conditions.cmd_mm - r.conditions.from_mm).array().sign().transpose();
    temperature.row(k).setConstant(r.conditions.temp_degc.value_or(0));
    time.row(k).setConstant(r.conditions.time_s.value_or(0));
    phi.row(k).setConstant(r.target.phi_rad);
  }
  std::vector<std::pair<std::string, double>> found = {
      {"the direction of approach", explained(trial.left_mm, direction)},
      {"the temperature", explained(trial.left_mm, temperature)},
      {"the time", explained(trial.left_mm, time)},
      {"the orientation", explained(trial.left_mm, phi)}};
  // A slope of noise takes 1 / n on average; ten times that is no chance.
  const double least = std::max(kWorthNaming, 10.0 / static_cast<double>(n));
  std::erase_if(found, [least](const auto& d) { return d.second < least; });
  return found;
}

Json row_json(const Trial& trial, const std::vector<Reading>& rows) {
  Json row = {{"method", trial.candidate.name}};
  if (!trial.failed.empty()) {
    row["failed"] = trial.failed;
    return row;
  }
  const Summary s = summarise(trial.position_mm);
  row["mean_mm"] = s.mean;
  row["p95_mm"] = s.p95;
  row["max_mm"] = s.max;
  row["n"] = s.n;
  row["depends_on"] = Json::object();
  for (const auto& [name, share] : dependences(trial, rows)) row["depends_on"][name] = share;
  return row;
}

/// The simplest of those that are not clearly worse than the best.
std::size_t pick(const std::vector<Trial>& trials) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < trials.size(); ++k) {
    if (!trials[k].failed.empty()) continue;
    if (summarise(trials[k].position_mm).mean < summarise(trials[best].position_mm).mean) best = k;
  }
  for (std::size_t k = 0; k < best; ++k) {
    if (!trials[k].failed.empty()) continue;
    const auto worse = paired_difference(trials[k].position_mm, trials[best].position_mm);
    if (worse && worse->low <= 0) return k;
  }
  return best;
}

std::vector<std::string> effect_names(const Campaign& campaign, StageResult& out) {
  std::vector<std::string> names;
  try {
    const Diagnosis diagnosis = diagnose(campaign);
    for (const NamedEffect& e : diagnosis.effects) {
      if (e.name != "outlier_readings") names.push_back(e.name);
    }
    out.words.push_back("diagnosis of the fitted rows: " + to_string(diagnosis.verdict) +
                        (names.empty() ? "" : fmt::format(" ({})", fmt::join(names, ", "))) +
                        "; effects were chosen on all rows, their values on each fold's");
  } catch (const InputError& error) {
    out.words.push_back(std::string("no diagnosis: ") + error.what());
  }
  return names;
}

void judge(const std::vector<Trial>& trials, std::size_t picked, const Campaign& campaign,
           const std::vector<Reading>& rows, StageResult& out) {
  const NoiseLevel noise = noise_level(campaign);
  const double mean_mm = summarise(trials[picked].position_mm).mean;
  out.details["picked"] = trials[picked].candidate.name;
  out.details["floor_mean_mm"] = perfect_mean_mm(campaign.machine, noise.sigma.xy_mm);
  const auto left = dependences(trials[picked], rows);
  std::string depends;
  for (const auto& [name, share] : left) {
    depends += fmt::format("{}{} ({:.0f} %)", depends.empty() ? "" : ", ", name, 100 * share);
  }
  out.words.push_back(fmt::format(
      "picked {}: held-out mean {:.4f} mm over {} readings; what it leaves goes with {}",
      trials[picked].candidate.name, mean_mm, rows.size(),
      depends.empty() ? "nothing that the readings record" : depends));
  out.words.push_back(
      "rule: the least held-out mean, or the simplest (topmost) method whose 95 % "
      "interval of the paired difference to it holds zero");
  out.words.push_back(floor_verdict(mean_mm, trials[picked].position_mm.size(), noise.sigma.xy_mm,
                                    noise.degrees_of_freedom, measured_places(campaign.machine)));
}

StageResult run_contest(const Campaign& campaign, const Json& parameters) {
  const std::vector<Reading> rows = identify_rows(campaign);
  if (rows.size() > kMost) {
    throw InputError({.what = "there are too many readings for a contest",
                      .got = std::to_string(rows.size()),
                      .expected = "at most " + std::to_string(kMost),
                      .hint = "name fewer sessions with --session"});
  }
  if (rows.size() < kFewest) {
    throw InputError({.what = "there are too few readings for a contest",
                      .got = std::to_string(rows.size()),
                      .expected = "at least " + std::to_string(kFewest)});
  }
  std::vector<Place> places;
  for (const Reading& r : rows) places.push_back({r.target.x_mm, r.target.y_mm});
  const std::vector<int> block = spatial_blocks(places, parameters["blocks"].get<int>(),
                                                parameters["seed"].get<std::uint64_t>());
  StageResult out;
  out.words.push_back(
      fmt::format("held-out: each of {} fitted readings as predicted without its spatial block ({} "
                  "blocks, the same for all methods)",
                  rows.size(), 1 + std::ranges::max(block)));
  Campaign fitted_rows = campaign;
  fitted_rows.readings = rows;
  std::vector<Trial> trials;
  for (const Candidate& c : candidates(campaign.machine, effect_names(fitted_rows, out))) {
    trials.push_back(tried(c, fitted_rows, rows, block));
    out.details["table"].push_back(row_json(trials.back(), rows));
    out.timing[c.name + "_s"] = trials.back().seconds;
  }
  const std::size_t picked = pick(trials);
  judge(trials, picked, campaign, rows, out);
  out.correction = fitted(trials[picked].candidate, fitted_rows);
  return out;
}

}  // namespace

Stage contest_stage() {
  return {.name = "contest",
          .algorithm_version = 13,
          .what = "all methods on one baseline with the same folds; picks one by a stated rule",
          .complete = complete_contest,
          .run = run_contest};
}

}  // namespace trammel::job
