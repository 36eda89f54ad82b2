#include "core/calibrate/machine_rank.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/statistics/random.hpp"

namespace trammel {

namespace {

constexpr int kRankPoses = 80;                     // as many as the paper measures
constexpr double kZeroColumn = 1e-12;              // of a tolerance
constexpr double kLeastSingular = 1e-9;            // of the largest: below it is rounding
constexpr double kMostTurnRad = rad_from_deg(20);  // of poses with varied orientation

/// Poses that are reached, in home's assembly and away from singular ones; limits are not asked.
std::vector<Pose> poses_about_home(const Machine& machine, bool turned) {
  const int n = machine.kind->n_chains;
  double stroke_mm = INFINITY;
  for (int i = 0; i < n; ++i) {
    const Limits& l = machine.drives[static_cast<std::size_t>(i)].limits;
    stroke_mm = std::min(stroke_mm, l.l_max_mm - l.l_min_mm);
  }
  const double half_mm = stroke_mm / 4;
  // A platform of 100 mm, as its kinds have them: its joints move about as far as its centre does.
  const double turn_rad = turned ? std::min(kMostTurnRad, half_mm / 100) : 0;
  Random random(1);
  std::vector<Pose> poses;
  for (int trial = 0; trial < 20 * kRankPoses && poses.size() < kRankPoses; ++trial) {
    Pose pose = machine.home;
    pose.x_mm += random.uniform(-half_mm, half_mm);
    if (n > 1) pose.y_mm += random.uniform(-half_mm, half_mm);
    pose.phi_rad += turn_rad * random.uniform(-1, 1);
    const Reach at = reach(machine, pose);
    if (at.assembly > 0 && at.singularity.margin() > 0.01) poses.push_back(pose);
  }
  if (poses.size() < kRankPoses) {
    throw InputError({.what = "about home hardly any pose can be reached",
                      .where = {.field = "home"},
                      .expected = "a home within the stroke, away from singular poses"});
  }
  return poses;
}

Identifiability rank_over(const Machine& machine, const std::vector<Pose>& poses,
                          std::size_t n_parameters) {
  const int n = machine.kind->n_chains;
  const auto& parameters = parameters_of(*machine.kind);
  std::vector<ScaledParameter> scaled;
  for (std::size_t k = 0; k < n_parameters; ++k) {
    scaled.push_back({parameters[k].name, parameters[k].is_angle, parameters[k].tolerance});
  }
  Eigen::MatrixXd A(static_cast<Eigen::Index>(poses.size()) * n,
                    static_cast<Eigen::Index>(n_parameters));
  for (std::size_t j = 0; j < poses.size(); ++j) {
    const Closures at = closures(machine, drives_at(machine, poses[j]).q_mm, poses[j]);
    ParameterColumns J = error_jacobian(at);
    J.row(2) *= 100;  // mm at 100 mm, as the other rows
    for (int c = 0; c < n; ++c) {
      if (!machine.measured[static_cast<std::size_t>(c)]) J.row(c).setZero();
    }
    A.middleRows(static_cast<Eigen::Index>(j) * n, n) = J.topRows(n).leftCols(A.cols());
  }
  for (Eigen::Index k = 0; k < A.cols(); ++k) {
    A.col(k) *= scaled[static_cast<std::size_t>(k)].tolerance;
  }
  const double largest = A.colwise().norm().maxCoeff();
  for (Eigen::Index k = 0; k < A.cols(); ++k) {
    if (A.col(k).norm() < kZeroColumn * largest) A.col(k).setZero();
  }
  // identifiability() counts singular values from kLeastSignal on.
  return identifiability(A * (kLeastSignal / (kLeastSingular * largest)), scaled,
                         static_cast<int>(poses.size()));
}

}  // namespace

std::vector<MachineRank> machine_ranks(const Machine& machine) {
  const auto& parameters = parameters_of(*machine.kind);
  const auto n_first =
      static_cast<std::size_t>(std::ranges::count(parameters, false, &MachineParameter::completes));
  std::vector<MachineRank> ranks;
  for (const bool turned : {false, true}) {
    if (turned && machine.kind->has_point_platform()) break;
    const std::vector<Pose> poses = poses_about_home(machine, turned);
    const char* const orientation = turned ? "varied" : "constant";
    ranks.push_back({orientation, "all", rank_over(machine, poses, parameters.size())});
    if (n_first == parameters.size()) continue;
    ranks.push_back({orientation, "the paper's", rank_over(machine, poses, n_first)});
  }
  return ranks;
}

}  // namespace trammel
