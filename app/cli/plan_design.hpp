#pragma once
// What a plan will tell before it is measured: options, text and JSON of `plan check
// --identifiability`, and the choice of points of `plan create optimal`.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/command_line.hpp"
#include "core/calibrate/optimal_plan.hpp"

namespace trammel::cli {

struct DesignOptions {
  double sigma_xy_mm = 0.010;
  double sigma_phi_deg = 0.004;
  std::vector<std::string> effects;

  [[nodiscard]] TrackerSigma sigma() const;
};
void design_options(Command command, DesignOptions& options);

/// A plan's rank, null space in words, observability indices and predicted uncertainty.
struct PlanDesign {
  Identifiability known;
  std::vector<IdentifiedCombination> base;  // with their uncertainty, without a value
  std::vector<Correlation> correlated;
  std::vector<std::string> words;
  double half_width_mm = 100;             // of the square: the paper's, else that of the plan
  PoseUncertainty level;                  // over the square at phi = 0
  std::optional<PoseUncertainty> turned;  // and at -5, 0, 5 deg, where the machine turns so far
};
PlanDesign design_of(const Plan& plan, const Machine& machine, const DesignOptions& options);
std::string design_text(const PlanDesign& design);
nlohmann::ordered_json design_json(const PlanDesign& design);

/// "predicted … paper-80 …": a plan beside the paper's, both in mean and max standard deviation.
/// Precondition: the machine is a 3-PRR.
std::string beside_paper_80(const Plan& plan, const Machine& machine, const DesignOptions& options);

}  // namespace trammel::cli
