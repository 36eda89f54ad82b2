#include "app/report/from_job.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/job/run.hpp"
#include "app/report/story.hpp"

namespace trammel::report {

namespace {

using Json = nlohmann::ordered_json;

ParameterRow parameter_row(const Json& p, const char* value) {
  ParameterRow row;
  row.name = p.at("name");
  row.unit = p.at("unit");
  row.epoch = p.value("epoch", 1);
  row.identified = p.value("identified", true);
  row.dropped = p.value("dropped", false);
  if (row.identified) {
    row.value = p.at(value);
    row.standard_uncertainty = p.at("standard_uncertainty");
  }
  return row;
}

/// Jobs of older versions do not say how large each kind of residual is.
std::string why_attitude(const Json& details) {
  if (!details.contains("attitude_rms_sigma")) return "";
  return fmt::format(
      "The fit weighs {:.4f} mm in x or y like {:.4f} deg in phi (the tracker's sigmas), and its "
      "constants cannot follow these readings: residuals of {:.1f} sigma in position, {:.1f} in "
      "attitude. So it gives attitude away for position; `trammel calibrate lsq --attitude-weight` "
      "above 1 gives it back.",
      details.at("sigma_xy_mm").get<double>(), details.at("sigma_phi_deg").get<double>(),
      details.at("position_rms_sigma").get<double>(),
      details.at("attitude_rms_sigma").get<double>());
}

}  // namespace

Identification identification_of(const store::Job& lsq) {
  const Json result = Json::parse(lsq.data.result_json);
  const Json& details = result.at("details");
  Identification found;
  found.job_key = lsq.data.key.key;
  found.rank = details.at("rank");
  found.columns = details.at("columns");
  for (const Json& p : details.at("parameters")) {
    found.parameters.push_back(parameter_row(p, "change"));
  }
  for (const Json& p : details.value("identified", Json::array())) {  // none in older versions
    if (!p.at("alone").get<bool>()) found.combinations.push_back(parameter_row(p, "change"));
  }
  found.words = result.at("words");
  found.sigma_ratio = details.at("sigma_ratio");
  found.explained = details.value("explained", found.explained);
  const Json parameters = Json::parse(lsq.data.parameters_json);
  if (parameters.value("attitude_weight", 1.0) == 1) found.why_attitude = why_attitude(details);
  return found;
}

NetworkFit network_of(const store::Job& rbf) {
  const Json details = Json::parse(rbf.data.result_json).at("details");
  const Json& training = details.at("training");
  NetworkFit fit;
  fit.neurons = details.at("neurons");
  fit.n = details.at("samples");
  fit.sigma_mm = details.at("sigma_mm");
  if (const Json& trials = details.at("trials"); !trials.empty()) {
    fit.least_sigma_mm = trials.front().at("sigma_mm");
    fit.largest_sigma_mm = trials.back().at("sigma_mm");
  }
  fit.mae_mm = training.at("mae_mm");
  fit.mse_mm2 = training.at("mse_mm2");
  for (std::size_t i = 0; i < fit.r2.size(); ++i) {
    fit.r2_pearson[i] = optional_number(training.at("joints").at(i).at("r2_pearson"));
    fit.r2[i] = optional_number(training.at("joints").at(i).at("r2"));
  }
  return fit;
}

std::string picked_of(const store::Job& contest) {
  return Json::parse(contest.data.result_json).at("details").value("picked", "");
}

std::string why_not_shown(const store::Job& job) {
  try {
    const Json result = Json::parse(job.data.result_json);
    if (job.data.stage == "lsq") static_cast<void>(identification_of(job));
    if (job.data.stage == "rbf") static_cast<void>(network_of(job));
    if (job.data.stage == "diagnose") static_cast<void>(round_of(job));
    static_cast<void>(job::correction_of(job.data.result_json));
    return "";
  } catch (const Json::exception& error) {
    return error.what();
  } catch (const Error& error) {
    return error.text().what;
  }
}

}  // namespace trammel::report
