#include <fmt/format.h>

#include <cmath>

#include "app/job/stages.hpp"
#include "core/calibrate/absorption.hpp"
#include "core/calibrate/geometry_fit.hpp"
#include "core/calibrate/identifiability.hpp"
#include "core/diagnose/diagnose.hpp"
#include "core/measure/noise.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr const char* kDiagnosed = "diagnosed";
constexpr double kAbsorbed = 4.0;  // tolerances: a machined part is not that far off
constexpr std::size_t kShiftsTold = 3;
constexpr double kSeed = 1e-6;  // of the usual range: "fit this parameter"

Json complete_model(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of the model");
  Fields f(file);
  Json all = {{"effects", f.has("effects") ? f.texts("effects") : std::vector<std::string>{}},
              {"robust", f.boolean("robust", false)},
              {"tolerance_prior", f.boolean("tolerance_prior", false)}};
  f.done();
  for (const Json& name : all["effects"]) {
    if (name != kDiagnosed) static_cast<void>(find_effect(name.get<std::string>()));
  }
  return all;
}

/// Where the fit starts: nominal, with the effects that are to be fitted.
RobotModel start_model(const Campaign& campaign, const Json& parameters, StageResult& out) {
  RobotModel model = nominal_model(campaign.mechanism);
  for (const Json& name : parameters["effects"]) {
    if (name == kDiagnosed) {
      const Diagnosis diagnosis = diagnose(campaign);
      model.effects = diagnosis.fit.model.effects;
      out.words.push_back("diagnosis: " + to_string(diagnosis.verdict));
      continue;
    }
    const Effect& effect = find_effect(name.get<std::string>());
    Eigen::VectorXd values(static_cast<Eigen::Index>(effect.parameters.size()));
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      values[k] = kSeed * effect.parameters[static_cast<std::size_t>(k)].usual_max;
    }
    model.effects.push_back({&effect, values});
  }
  return model;
}

std::vector<ScaledParameter> scaled(const std::vector<FreeParameter>& parameters) {
  std::vector<ScaledParameter> all;
  for (const FreeParameter& p : parameters) {
    const bool angle = p.unit == "deg" && p.kind != FreeParameter::Kind::effect;
    all.push_back({p.name, angle, p.scale});
  }
  return all;
}

Json parameter_json(const GeometryFit& fit, const Identifiability& known, std::size_t k) {
  const FreeParameter& p = fit.parameters[k];
  const auto row = static_cast<Eigen::Index>(k);
  Json json = {
      {"name", p.name}, {"unit", p.unit}, {"identified", known.identified[k] ? true : false}};
  if (!known.identified[k]) {
    json["why"] = "not identifiable by itself from these readings";
    return json;
  }
  const bool angle = p.unit == "deg" && p.kind != FreeParameter::Kind::effect;
  const double unit = p.scale * (angle ? deg_from_rad(1) : 1);
  json["change"] = unit * fit.z[row];
  json["standard_uncertainty"] = unit * std::sqrt(fit.covariance(row, row));
  return json;
}

/// Parameters of the geometry that are further off than machining puts them.
void alarm(const GeometryFit& fit, const Identifiability& known, StageResult& out) {
  for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
    const FreeParameter& p = fit.parameters[k];
    const auto row = static_cast<Eigen::Index>(k);
    const double off = std::abs(fit.z[row]);
    const double sure = off - 2 * std::sqrt(fit.covariance(row, row));
    if (p.kind != FreeParameter::Kind::geometry || !known.identified[k] || sure < kAbsorbed)
      continue;
    out.words.push_back(fmt::format(
        "absorption alarm: {} is {:.1f} tolerances from nominal: probably soaking up an unmodelled "
        "effect",
        p.name, off));
  }
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
      text += fmt::format("{}{} by {:+.4f} +- {:.4f}{}", told++ == 0 ? "" : ", ", s.name,
                          json["shift"].get<double>(), json["standard_uncertainty"].get<double>(),
                          !s.single    ? ""
                          : s.is_angle ? " deg"
                                       : "");
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
      fmt::format("family-wise false alarm {:g} % over {} parameters and combinations",
                  100 * test.false_alarm, test.in_time.tests);
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

GeometryFit fit(const Campaign& campaign, const Json& parameters, StageResult& out) {
  const NoiseLevel noise = noise_level(campaign);
  const std::vector<Reading> rows = identify_rows(campaign);
  GeometryFit result = fit_geometry(start_model(campaign, parameters, out), rows, noise.sigma,
                                    {.huber = parameters["robust"].get<bool>(),
                                     .tolerance_prior = parameters["tolerance_prior"].get<bool>()});
  const auto names = scaled(result.parameters);
  const Identifiability known = identifiability(result.system.jacobian, names);
  const Observability& o = known.observability;
  out.details = {
      {"noise", noise.words},
      {"converged", result.status == GeometryFit::Status::converged},
      {"iterations", result.iterations},
      {"equations", 3 * rows.size()},
      {"columns", result.parameters.size()},
      {"rank", result.identified.rank},
      {"weighted_rss", result.chi2},
      {"sigma_ratio", result.dof > 0 ? std::sqrt(result.chi2 / result.dof) : 0.0},
      {"observability", {{"O1", o.O1}, {"O2", o.O2}, {"O3", o.O3}, {"O4", o.O4}, {"O5", o.O5}}}};
  for (std::size_t k = 0; k < result.parameters.size(); ++k) {
    out.details["parameters"].push_back(parameter_json(result, known, k));
  }
  for (std::string& sentence : in_words(known, names)) out.words.push_back(std::move(sentence));
  alarm(result, known, out);
  halves(result, rows, out);
  for (std::size_t j = 0; j < rows.size() && parameters["robust"].get<bool>(); ++j) {
    const double weight = result.weights[static_cast<Eigen::Index>(j)];
    if (weight >= 1) continue;
    out.details["downweighted"].push_back({{"seq", rows[j].seq}, {"weight", weight}});
  }
  out.words.push_back(fmt::format("residuals are {:.2f} times the noise",
                                  out.details["sigma_ratio"].get<double>()));
  return result;
}

StageResult run_geometry(const Campaign& campaign, const Json& parameters) {
  StageResult out;
  out.correction = ModelCorrection{fit(campaign, parameters, out).model};
  return out;
}

StageResult run_hybrid(const Campaign& campaign, const Json& parameters) {
  StageResult out;
  const RobotModel model = fit(campaign, parameters, out).model;
  const GpMap left = fit_gp(samples_left(model, identify_rows(campaign)));
  for (std::size_t i = 0; i < kChains; ++i) {
    const GpJoint& j = left.joints[i];
    out.words.push_back(fmt::format(
        "left for the map on joint {}: {:.4f} mm over {:.0f} mm, beside noise of {:.4f} mm", i + 1,
        j.signal_mm, j.length_mm, j.noise_mm));
  }
  out.correction = HybridCorrection{model, left};
  return out;
}

Json complete_gp(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of gp");
  const Fields f(file);
  f.done();
  return Json::object();
}

StageResult run_gp(const Campaign& campaign, const Json&) {
  const GpMap map = fit_gp(joint_samples(campaign.mechanism, identify_rows(campaign)));
  StageResult out{.correction = MapCorrection{map}, .details = {}, .words = {}};
  for (std::size_t i = 0; i < kChains; ++i) {
    const GpJoint& j = map.joints[i];
    out.details["joints"].push_back({{"joint", i + 1},
                                     {"length_mm", j.length_mm},
                                     {"signal_mm", j.signal_mm},
                                     {"noise_mm", j.noise_mm}});
    out.words.push_back(fmt::format(
        "joint {}: errors of {:.4f} mm over {:.0f} mm, and {:.4f} mm that no place explains", i + 1,
        j.signal_mm, j.length_mm, j.noise_mm));
  }
  return out;
}

}  // namespace

Stage geometry_stage() {
  return {.name = "geometry",
          .algorithm_version = 2,
          .what = "the complete nonlinear model, with named effects if asked for",
          .complete = complete_model,
          .run = run_geometry};
}

Stage gp_stage() {
  return {.name = "gp",
          .algorithm_version = 1,
          .what = "Gaussian-process regression of joint errors",
          .complete = complete_gp,
          .run = run_gp};
}

Stage hybrid_stage() {
  return {.name = "hybrid",
          .algorithm_version = 2,
          .what = "the physical model first, a Gaussian process on what it leaves",
          .complete = complete_model,
          .run = run_hybrid};
}

}  // namespace trammel::job
