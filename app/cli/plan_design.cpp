#include "app/cli/plan_design.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/terminal/counted.hpp"
#include "core/plan/named.hpp"
#include "core/units.hpp"

namespace trammel::cli {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kUmPerMm = 1000;
constexpr double kTurnRad = rad_from_deg(5.0);

std::string uncertainty_line(const std::string& where, const PoseUncertainty& u) {
  return fmt::format("  {:<24} mean {:7.2f} um {:8.5f} deg   max {:7.2f} um {:8.5f} deg\n", where,
                     kUmPerMm * u.mean_mm, deg_from_rad(u.mean_rad), kUmPerMm * u.max_mm,
                     deg_from_rad(u.max_rad));
}

/// U (k = 2) in the unit it is shown in.
double expanded(const IdentifiedCombination& c) {
  return 2 * (c.is_angle ? deg_from_rad(1) : 1) * c.standard_uncertainty;
}

Json base_json(const PlanDesign& d) {
  Json base = Json::array();
  for (const IdentifiedCombination& c : d.base) {
    base.push_back({{"name", c.name}, {"unit", c.unit}, {"alone", c.alone}, {"U_k2", expanded(c)}});
  }
  return base;
}

Json correlations_json(const PlanDesign& d) {
  Json all = Json::array();
  for (const Correlation& c : d.correlated) {
    all.push_back({{"a", d.base[static_cast<std::size_t>(c.a)].name},
                   {"b", d.base[static_cast<std::size_t>(c.b)].name},
                   {"r", c.r}});
  }
  return all;
}

Json uncertainty_json(const PoseUncertainty& u) {
  return {{"mean_mm", u.mean_mm},
          {"max_mm", u.max_mm},
          {"mean_deg", deg_from_rad(u.mean_rad)},
          {"max_deg", deg_from_rad(u.max_rad)}};
}

/// Of the square about the origin that holds the plan.
double half_width_of(const Plan& plan) {
  double half = 0;
  for (const PlannedPoint& p : plan.points) {
    half = std::max({half, std::abs(p.target.x_mm), std::abs(p.target.y_mm)});
  }
  return half > 0 ? half : 1;
}

}  // namespace

TrackerSigma DesignOptions::sigma() const { return {sigma_xy_mm, rad_from_deg(sigma_phi_deg)}; }

void design_options(Command c, DesignOptions& o) {
  c.option("--sigma-xy", o.sigma_xy_mm, "of one tracker reading, mm").shown_default();
  c.option("--sigma-phi", o.sigma_phi_deg, "of one tracker reading, deg").shown_default();
  c.option("--effects", o.effects, "to identify beside the geometry, with commas")
      .delimiter(',')
      .type("EFFECT");
}

PlanDesign design_of(const Plan& plan, const Machine& machine, const DesignOptions& options) {
  const DesignModel model = design_model(machine, options.sigma(), options.effects);
  const Eigen::MatrixXd J = design_jacobian(model, expected_conditions(plan, machine));
  const auto parameters = scaled_parameters(model.parameters);
  PlanDesign design;
  design.known = identifiability(model, J);
  const Eigen::MatrixXd expected = covariance(design.known, parameters);
  design.base = identified_combinations(design.known, parameters, expected);
  design.correlated = strong_correlations(design.base, expected);
  design.words = in_words(design.known, parameters, design.base, design.correlated);
  const bool is_prr = machine.kind->chain == &kPrrChain;
  if (!is_prr) design.half_width_mm = half_width_of(plan);
  const auto poses = [&](const std::vector<double>& turns) {
    return is_prr ? comparison_poses(turns, design.half_width_mm)
                  : comparison_poses(machine, turns, design.half_width_mm);
  };
  const std::vector<double> turns = {-kTurnRad, 0.0, kTurnRad};
  design.level = predicted_uncertainty(model, J, poses({0.0}));
  const std::vector<Pose> turned = poses(turns);
  const bool turns_so_far =
      std::ranges::any_of(turned, [](const Pose& p) { return p.phi_rad > 0; });
  if (turns_so_far) design.turned = predicted_uncertainty(model, J, turned);
  return design;
}

std::string design_text(const PlanDesign& d) {
  std::string text;
  for (const std::string& sentence : d.words) text += sentence + "\n";
  std::string alone;
  for (const IdentifiedCombination& c : d.base) {
    if (!c.alone) continue;
    alone += fmt::format("  {:<24} +- {:.4g} {} (k = 2)\n", c.name, expanded(c), c.unit);
  }
  text += alone.empty() ? "no parameter is identified by itself\n"
                        : "identified by themselves:\n" + alone;
  const Observability& o = d.known.observability;
  text += fmt::format(
      "observability of what is identified: O1 {:.4g}  O2 {:.4g}  O3 {:.4g}  O4 "
      "{:.4g}  O5 {:.4g}\n",
      o.O1, o.O2, o.O3, o.O4, o.O5);
  text += fmt::format("predicted standard deviation of the pose after the fit, over +-{:g} mm:\n",
                      d.half_width_mm);
  text += uncertainty_line("at phi = 0", d.level);
  return d.turned ? text + uncertainty_line("at phi = -5, 0, 5 deg", *d.turned) : text;
}

Json design_json(const PlanDesign& d) {
  const Observability& o = d.known.observability;
  Json missing = Json::array();
  for (const NullDirection& direction : d.known.null_space) missing.push_back(direction.sentence);
  Json predicted = {{"half_width_mm", d.half_width_mm}, {"level", uncertainty_json(d.level)}};
  if (d.turned) predicted["turned"] = uncertainty_json(*d.turned);
  return {{"rank", d.known.rank},
          {"parameters", d.known.singular.size()},
          {"not_identified", missing},
          {"identified", base_json(d)},
          {"correlations", correlations_json(d)},
          {"observability", {{"O1", o.O1}, {"O2", o.O2}, {"O3", o.O3}, {"O4", o.O4}, {"O5", o.O5}}},
          {"predicted_sd", predicted}};
}

std::string beside_paper_80(const Plan& plan, const Machine& machine,
                            const DesignOptions& options) {
  const PlanDesign ours = design_of(plan, machine, options);
  const PlanDesign paper = design_of(named_plan("paper-80"), machine, options);
  return "predicted standard deviation of the pose after the fit, over +-100 mm and -5, 0, 5 "
         "deg:\n" +
         uncertainty_line(
             fmt::format("{}, {}", plan.name, terminal::counted(plan.points.size(), "point")),
             ours.turned.value()) +
         uncertainty_line("paper-80, 80 points", paper.turned.value()) +
         "the same at phi = 0 alone:\n" +
         uncertainty_line(
             fmt::format("{}, {}", plan.name, terminal::counted(plan.points.size(), "point")),
             ours.level) +
         uncertainty_line("paper-80, 80 points", paper.level);
}

}  // namespace trammel::cli
