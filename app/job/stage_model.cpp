#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/files/numbers.hpp"
#include "app/job/by_axis.hpp"
#include "app/job/held_out.hpp"
#include "app/job/identification.hpp"
#include "app/job/stages.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/decimals.hpp"
#include "core/calibrate/absorption.hpp"
#include "core/calibrate/geometry_fit.hpp"
#include "core/calibrate/identifiability.hpp"
#include "core/diagnose/diagnose.hpp"
#include "core/judge/deviation.hpp"
#include "core/measure/bad_readings.hpp"
#include "core/measure/noise.hpp"
#include "core/model/history.hpp"
#include "core/plane/blocks.hpp"
#include "core/statistics/interval.hpp"
#include "core/statistics/summary.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr const char* kDiagnosed = "diagnosed";
constexpr int kBlocks = 6;  // of the cross-validation, as in the contest
constexpr std::size_t kShiftsTold = 3;
constexpr std::size_t kOutliersTold = 10;
constexpr double kSeed = 1e-6;  // of the usual range: "fit this parameter"

Json complete_model(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of the model");
  Fields f(file);
  Json all = {{"effects", f.has("effects") ? f.texts("effects") : std::vector<std::string>{}},
              {"epochs", f.choice("epochs", {"auto", "own", "shared"}, "auto")},
              {"robust", f.boolean("robust", false)},
              {"tolerance_prior", f.boolean("tolerance_prior", false)}};
  f.done();
  for (const Json& name : all["effects"]) {
    if (name != kDiagnosed) static_cast<void>(find_effect(name.get<std::string>()));
  }
  return all;
}

std::size_t n_drives(const Campaign& campaign) {
  return static_cast<std::size_t>(campaign.machine.kind->n_chains);
}

/// Where the fit starts: nominal, with the effects that are to be fitted.
RobotModel start_model(const Campaign& campaign, const Json& parameters, StageResult& out) {
  RobotModel model = nominal_model(campaign.machine);
  model.history = std::make_shared<History>(campaign.machine, campaign.readings);
  for (const Json& name : parameters["effects"]) {
    if (name == kDiagnosed) {
      const Diagnosis diagnosis = diagnose(campaign);
      model.effects = diagnosis.fit.model.effects;
      out.words.push_back("diagnosis: " + to_string(diagnosis.verdict));
      continue;
    }
    const Effect& effect = find_effect(name.get<std::string>());
    require_effect(effect, campaign.machine);
    Eigen::VectorXd values = usual_shapes(effect);
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      if (!exists(effect, static_cast<int>(k), campaign.machine)) continue;
      values[k] = kSeed * effect.parameters[static_cast<std::size_t>(k)].usual_max;
    }
    model.effects.push_back({&effect, values});
  }
  return model;
}

Json shift_json(const HalfShift& s) {
  const double unit = s.is_angle ? deg_from_rad(1) : 1;
  return {{"name", s.name},
          {"single", s.single},
          {"unit", s.unit},
          {"shift", unit * s.shift},
          {"standard_uncertainty", unit * s.standard_uncertainty},
          {"sigmas", s.sigmas()}};
}

Json halves_json(const HalvesTest& test) {
  Json json = {{"tests", test.tests},
               {"limit_sigmas", test.limit_sigmas},
               {"noise_ratio", test.noise_ratio},
               {"shifts", Json::array()}};
  if (!test.untested.empty()) json["untested"] = test.untested;
  for (const HalfShift& s : test.shifts) json["shifts"].push_back(shift_json(s));
  return json;
}

/// The surest shifts in words: "l_1 by +0.0213 +- 0.0040, …".
std::string shift_words(const HalvesTest& test) {
  std::string text;
  std::size_t told = 0;
  for (const bool single : {true, false}) {
    for (const HalfShift& s : test.shifts) {
      if (s.single != single || told == kShiftsTold) continue;
      const Json json = shift_json(s);
      const double u = json["standard_uncertainty"];
      const int decimals = terminal::decimals_of(u);
      text += fmt::format("{}{} by {:+.{}f} +- {:.{}f}{}", told++ == 0 ? "" : ", ", s.name,
                          rounded(json["shift"].get<double>(), decimals), decimals, u, decimals,
                          !s.single || s.unit == "1" ? "" : " " + s.unit);
    }
  }
  if (test.shifts.size() > told) text += fmt::format(" and {} more", test.shifts.size() - told);
  return text;
}

/// Parameters that differ between halves of the readings by more than their uncertainty allows.
void halves(const GeometryFit& fit, const std::vector<Reading>& rows, StageResult& out) {
  const AbsorptionTest test = absorption_test(fit, rows);
  out.details["absorption"] = {{"false_alarm", test.false_alarm},
                               {"in_time", halves_json(test.in_time)},
                               {"interleaved", halves_json(test.interleaved)}};
  if (!test.in_time.untested.empty()) {
    out.words.push_back("absorption by halves not tested: " + test.in_time.untested);
    return;
  }
  const std::string rate =
      fmt::format("family-wise false alarm {:g} % over {} of parameters and combinations",
                  100 * test.false_alarm, terminal::counted(test.in_time.tests, "test"));
  const bool in_time = !test.in_time.shifts.empty();
  const bool control = !test.interleaved.shifts.empty();
  if (in_time) {
    out.words.push_back(fmt::format(
        "absorption alarm: between the first and the second half of the readings shifts {} ({}): "
        "probably soaking up an unmodelled effect, {}",
        shift_words(test.in_time), rate,
        control ? "not of time alone: interleaved halves differ too"
                : "of time, or of what else tells the halves apart (place, approach): interleaved "
                  "halves agree"));
  }
  if (control) {
    out.words.push_back(fmt::format(
        "absorption alarm of the control: between interleaved halves shifts {} ({}): noise larger "
        "than stated, or an unmodelled effect of place or approach",
        shift_words(test.interleaved), rate));
  }
  if (!in_time && !control) {
    out.words.push_back(
        fmt::format("absorption: first and second half of the readings agree, and so do "
                    "interleaved halves ({})",
                    rate));
  }
}

/// Readings that do not belong to the rest, by seq: none is dropped.
void outliers(const GeometryFit& judged, const std::vector<Reading>& rows, bool robust,
              StageResult& out) {
  const std::vector<OutlyingReading> found = outlying_readings(judged, rows);
  out.details["outliers"] = Json::array();
  std::string named;
  for (const OutlyingReading& o : found) {
    out.details["outliers"].push_back(
        {{"seq", o.seq}, {"sigmas", o.sigmas}, {"weight", robust ? o.weight : 1.0}});
    if (out.details["outliers"].size() > kOutliersTold) continue;
    named += fmt::format("{}seq {} ({:.1f} sigmas{})", named.empty() ? "" : ", ", o.seq, o.sigmas,
                         robust ? fmt::format(", weight {:.2f}", o.weight) : "");
  }
  if (found.empty()) return;
  if (found.size() > kOutliersTold) {
    named += fmt::format(" and {} more", found.size() - kOutliersTold);
  }
  out.words.push_back(fmt::format(
      "{} of {} {} not belong to the rest: {} (family-wise false alarm {:g} %); none is "
      "dropped, {}",
      found.size(), terminal::counted(rows.size(), "reading"), found.size() == 1 ? "does" : "do",
      named, 100 * kFalseOutlying,
      robust ? "they count less"
             : "they count in full: --robust lets them count less, `trammel "
               "reading exclude` leaves them out"));
}

/// The fit that judges single readings where wrong ones may bend the fit of all: robust, and
/// without those that are wrong for certain.
GeometryFit fit_of_most(const RobotModel& start, const std::vector<Reading>& rows,
                        const std::vector<Suspicion>& bad, const TrackerSigma& sigma,
                        GeometryFitOptions options) {
  const auto is_bad = [&bad](const Reading& r) {
    return std::ranges::any_of(bad, [&r](const Suspicion& s) { return s.seqs.front() == r.seq; });
  };
  std::vector<Reading> rest = rows;
  std::erase_if(rest, is_bad);
  options.huber = true;
  GeometryFit fit = fit_geometry(start, rest, sigma, options);
  fit.system = whitened_system(fit.model, rows, sigma, fit.parameters);
  const Eigen::VectorXd weights =
      std::exchange(fit.weights, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rows.size())));
  Eigen::Index next = 0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (!is_bad(rows[k])) fit.weights[static_cast<Eigen::Index>(k)] = weights[next++];
  }
  return fit;
}

/// chi2 by which uncertainties are judged. Huber's psi in place of the residual (Huber 1981, Sec.
/// 7.6): what counts less spreads less.
double judged_chi2(const GeometryFit& fit, bool robust) {
  if (!robust) return fit.chi2;
  double psi2 = 0, whole = 0;
  for (Eigen::Index i = 0; i < fit.weights.size(); ++i) {
    psi2 += fit.weights[i] * fit.weights[i] * fit.system.residual.segment<3>(3 * i).squaredNorm();
    whole += fit.weights[i] < 1 ? 0 : 1;
  }
  const double share = whole / static_cast<double>(fit.weights.size());
  return share > 0 ? psi2 / (share * share) : fit.chi2;
}

GeometryFit fit(const Campaign& campaign, const Json& parameters, StageResult& out) {
  const NoiseLevel noise = noise_level(campaign);
  const std::vector<Reading> rows = with_epochs(identify_rows(campaign), campaign.machine,
                                                parameters["epochs"].get<std::string>(), out.words);
  const bool robust = parameters["robust"].get<bool>();
  const RobotModel start = start_model(campaign, parameters, out);
  GeometryFitOptions options{.huber = robust,
                             .tolerance_prior = parameters["tolerance_prior"].get<bool>()};
  GeometryFit result = fit_geometry(start, rows, noise.sigma, options);
  const auto names = scaled_parameters(result.parameters);
  const Identifiability known = identifiability(result.system.jacobian, names);
  const auto n = static_cast<Eigen::Index>(names.size());
  Eigen::VectorXd scales(n), values(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const FreeParameter& p = result.parameters[static_cast<std::size_t>(k)];
    scales[k] = p.scale;
    values[k] = p.kind == FreeParameter::Kind::effect  // its value, not the change from the start
                    ? result.model.effects[static_cast<std::size_t>(p.owner)].values[p.index]
                    : p.scale * result.z[k];
  }
  const Identification found{
      .known = known,
      .parameters = names,
      .values = values,
      .covariance = scales.asDiagonal() * result.covariance * scales.asDiagonal(),
      .n_geometry = parameters_of(*campaign.machine.kind).size(),
      .goodness = goodness(judged_chi2(result, robust), result.dof, noise.degrees_of_freedom)};
  IdentificationReport told = identification_report(found);
  out.details = std::move(told.details);
  out.details["noise"] = noise.words;
  out.details["converged"] = result.status == GeometryFit::Status::converged;
  out.details["iterations"] = result.iterations;
  out.details["damped_steps"] = result.damped;
  out.details["equations"] =
      static_cast<std::size_t>(std::ranges::count(campaign.machine.measured, true)) * rows.size();
  out.details["weighted_rss"] = result.chi2;
  std::ranges::move(told.words, std::back_inserter(out.words));
  halves(result, rows, out);
  const std::vector<Suspicion> bad = bad_readings(campaign);
  const bool bent = !bad.empty() || (!robust && !found.goodness.explained);
  outliers(bent ? fit_of_most(start, rows, bad, noise.sigma, options) : result, rows, robust, out);
  if (result.status != GeometryFit::Status::converged) {
    out.words.push_back(
        fmt::format("warning: the fit did not converge in {}: judge it by held-out figures alone",
                    terminal::counted(result.iterations, "step")));
  }
  return result;
}

StageResult run_geometry(const Campaign& campaign, const Json& parameters) {
  StageResult out;
  const RobotModel model = fit(campaign, parameters, out).model;
  const std::string by_axis = left_by_axis(model, campaign);
  if (!by_axis.empty()) out.words.push_back(by_axis);
  out.correction = ModelCorrection{model};
  return out;
}

/// Position errors of the readings, each under a correction fitted without its spatial block.
std::vector<double> held_out_mm(const Fit& fit_one, const Campaign& campaign,
                                const std::vector<Reading>& rows, const std::vector<int>& block) {
  const std::vector<Pose> after = held_out_poses(fit_one, campaign, rows, block);
  std::vector<double> errors;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    errors.push_back(position_error_mm(after[k], rows[k].target));
  }
  return errors;
}

/// The model under a map. What the geometry lacks it would take up with the zeros and frames of
/// each epoch as well, in each another way, and leave a field that differs between epochs: no map
/// follows that. So the epochs' shifts are those that maps take out, beside a smooth error.
RobotModel model_under_map(const Campaign& campaign, const Json& parameters, StageResult& out) {
  StageResult of_epochs;
  MapRows from = map_rows(campaign, parameters, of_epochs);
  if (from.shifts.empty()) return fit(campaign, parameters, out).model;
  std::ranges::move(of_epochs.words, std::back_inserter(out.words));
  Campaign one_epoch = campaign;
  std::erase_if(one_epoch.readings, [](const Reading& r) { return r.set == ReadingSet::identify; });
  std::ranges::move(from.rows, std::back_inserter(one_epoch.readings));
  Json shared = parameters;
  shared["epochs"] = "shared";
  RobotModel model = fit(one_epoch, shared, out).model;
  model.epochs = from.shifts;
  return model;
}

/// Whether the map lowers the error of readings that neither it nor the model saw, beyond chance.
bool map_helps(const Campaign& campaign, const Json& parameters, const std::vector<Reading>& rows,
               StageResult& out) {
  std::vector<Place> places;
  for (const Reading& r : rows) places.push_back({r.target.x_mm, r.target.y_mm});
  const std::vector<int> block = spatial_blocks(places, kBlocks);
  const auto model_of = [&parameters](const Campaign& training) {
    StageResult unused;
    return model_under_map(training, parameters, unused);
  };
  try {
    const auto without =
        held_out_mm([&](const Campaign& training) { return ModelCorrection{model_of(training)}; },
                    campaign, rows, block);
    const auto with = held_out_mm(
        [&](const Campaign& training) {
          const RobotModel model = model_of(training);
          return HybridCorrection{model, fit_gp(samples_left(model, identify_rows(training)))};
        },
        campaign, rows, block);
    const auto change = paired_difference(with, without);
    const bool helps = change && change->high < 0;
    out.details["map"] = {{"used", helps},
                          {"held_out_mean_without_mm", summarise(without).mean},
                          {"held_out_mean_with_mm", summarise(with).mean}};
    out.words.push_back(fmt::format(
        "{} spatial blocks held out in turn: mean {} mm with the model alone, {} mm with "
        "the map: {}",
        kBlocks, terminal::figure_text(summarise(without).mean),
        terminal::figure_text(summarise(with).mean),
        helps ? "the map helps, and is used"
              : "the map does not help beyond chance, and is left out"));
    return helps;
  } catch (const InputError& error) {
    out.details["map"] = {{"used", false}};
    out.words.push_back(std::string("the map is left out, since nothing could be held out: ") +
                        error.text().what);
    return false;
  }
}

Json complete_hybrid(const Json& given) {
  Json of_model = given;
  of_model.erase("map");
  Json all = complete_model(of_model);
  const JsonFile file = parse_json(given.dump(), "parameters of hybrid");
  Fields f(file);
  all["map"] = f.choice("map", {"when-it-helps", "always"}, "when-it-helps");
  return all;
}

StageResult run_hybrid(const Campaign& campaign, const Json& parameters) {
  StageResult out;
  const std::vector<Reading> rows = identify_rows(campaign);
  require_all_measured(campaign.machine);
  if (rows.size() > kMostGpSamples) {  // refused before the long fit
    static_cast<void>(fit_gp(joint_samples(campaign.machine, rows)));
  }
  const RobotModel model = model_under_map(campaign, parameters, out);
  const GpMap left = fit_gp(samples_left(model, rows));
  for (std::size_t i = 0; i < n_drives(campaign); ++i) {
    const GpJoint& j = left.joints[i];
    out.words.push_back(fmt::format(
        "left for the map on joint {}: {} mm over {:.0f} mm, beside noise of {} mm", i + 1,
        terminal::figure_text(j.signal_mm), j.length_mm, terminal::figure_text(j.noise_mm)));
  }
  const bool used = parameters["map"] == "always" || map_helps(campaign, parameters, rows, out);
  if (used) {
    out.correction = HybridCorrection{model, left};
  } else {
    out.correction = ModelCorrection{model};
  }
  return out;
}

Json complete_gp(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of gp");
  Fields f(file);
  const Json all = {{"epochs", f.choice("epochs", {"auto", "own", "shared"}, "auto")}};
  f.done();
  return all;
}

StageResult run_gp(const Campaign& campaign, const Json& parameters) {
  StageResult out;
  const MapRows from = map_rows(campaign, parameters, out);
  const GpMap map = fit_gp(joint_samples(campaign.machine, from.rows));
  out.correction = MapCorrection{map, from.shifts};
  for (std::size_t i = 0; i < n_drives(campaign); ++i) {
    const GpJoint& j = map.joints[i];
    out.details["joints"].push_back({{"joint", i + 1},
                                     {"length_mm", j.length_mm},
                                     {"signal_mm", j.signal_mm},
                                     {"noise_mm", j.noise_mm}});
    out.words.push_back(fmt::format(
        "joint {}: errors of {} mm over {:.0f} mm, and {} mm that no place explains", i + 1,
        terminal::figure_text(j.signal_mm), j.length_mm, terminal::figure_text(j.noise_mm)));
  }
  return out;
}

}  // namespace

Stage geometry_stage() {
  return {.name = "geometry",
          .algorithm_version = 11,
          .what = "the complete nonlinear model, with named effects if asked for",
          .complete = complete_model,
          .run = run_geometry};
}

Stage gp_stage() {
  return {.name = "gp",
          .algorithm_version = 7,
          .what = "Gaussian-process regression of joint errors",
          .complete = complete_gp,
          .run = run_gp,
          .serves = serves_measured};
}

Stage hybrid_stage() {
  return {
      .name = "hybrid",
      .algorithm_version = 11,
      .what = "the physical model first, a Gaussian process on what it leaves, where that helps",
      .complete = complete_hybrid,
      .run = run_hybrid,
      .serves = serves_measured};
}

}  // namespace trammel::job
