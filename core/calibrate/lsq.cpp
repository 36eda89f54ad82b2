#include "core/calibrate/lsq.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/assess/deviation.hpp"
#include "core/error.hpp"
#include "core/mechanism/error_model.hpp"
#include "core/mechanism/forward.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr int kEpochColumns = 6;
constexpr double kZeroToleranceMm = 0.1, kFrameToleranceMm = 0.1;
constexpr double kFrameToleranceRad = rad_from_deg(0.05);

/// Whitened, in tolerances.
struct System {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  std::vector<ScaledParameter> parameters;
  std::vector<int> epochs;  // of each column, 1 for the geometry
};

void require_sigma(const TrackerSigma& sigma) {
  if (std::isfinite(sigma.xy_mm) && sigma.xy_mm > 0 && std::isfinite(sigma.phi_rad) &&
      sigma.phi_rad > 0) {
    return;
  }
  throw InputError({.what = "the readings cannot be weighted",
                    .where = {.field = "tracker"},
                    .got = "sigma " + std::to_string(sigma.xy_mm) + " mm, " +
                           std::to_string(deg_from_rad(sigma.phi_rad)) + " deg",
                    .expected = "positive standard deviations"});
}

/// Later epochs in order; they own columns unless shared.
std::vector<int> later_epochs(std::span<const Reading> readings, const LsqOptions& options) {
  std::set<int> epochs;
  for (const Reading& r : readings) epochs.insert(r.conditions.epoch);
  if (!epochs.empty()) epochs.erase(epochs.begin());
  if (options.shared_epochs) epochs.clear();
  return {epochs.begin(), epochs.end()};
}

void name_columns(System& system, const std::vector<int>& later, int geometry_columns) {
  for (int k = 0; k < geometry_columns; ++k) {
    const GeometryParameter& p = geometry_parameters()[static_cast<std::size_t>(k)];
    system.parameters.push_back({p.name, p.is_angle, p.tolerance});
    system.epochs.push_back(1);
  }
  for (const int epoch : later) {
    const std::string of = " of epoch " + std::to_string(epoch);
    for (int i = 1; i <= kChains; ++i) {
      system.parameters.push_back({"zero_" + std::to_string(i) + of, false, kZeroToleranceMm});
    }
    system.parameters.push_back({"frame_x" + of, false, kFrameToleranceMm});
    system.parameters.push_back({"frame_y" + of, false, kFrameToleranceMm});
    system.parameters.push_back({"frame_phi" + of, true, kFrameToleranceRad});
    system.epochs.insert(system.epochs.end(), kEpochColumns, epoch);
  }
}

ForwardResult nominal_pose(const Mechanism& mechanism, const Reading& reading) {
  const ForwardResult at = forward(mechanism.geometry, reading.conditions.cmd_mm, mechanism.home);
  const std::string point = "seq " + std::to_string(reading.seq);
  if (!at.ok()) {
    throw InputError({.what = "the commanded displacements are out of the nominal robot's reach",
                      .where = {.point = point}});
  }
  if (!reading.measured) {
    throw InputError({.what = "this reading has no measured pose", .where = {.point = point}});
  }
  return at;
}

/// d(x, y, phi) of the three joint zeros and the frame offset (added to the reading) of an epoch.
Eigen::Matrix<double, 3, kEpochColumns> epoch_columns(const ErrorJacobian& J_e) {
  Eigen::Matrix<double, 3, kEpochColumns> J;
  for (int i = 0; i < kChains; ++i) J.col(i) = J_e.col(6 * i + 4);  // as the joint zero l_i
  J.rightCols<3>().setIdentity();
  return J;
}

System make_system(const Mechanism& mechanism, std::span<const Reading> readings,
                   const TrackerSigma& sigma, const LsqOptions& options) {
  const int geometry_columns = options.complete ? kGeometryParameters : kPaperParameters;
  const std::vector<int> later = later_epochs(readings, options);
  System system;
  name_columns(system, later, geometry_columns);
  const auto rows = static_cast<Eigen::Index>(3 * readings.size());
  system.A.setZero(rows, static_cast<Eigen::Index>(system.parameters.size()));
  system.b.resize(rows);
  const Eigen::Vector3d weight(1 / sigma.xy_mm, 1 / sigma.xy_mm, 1 / sigma.phi_rad);
  for (std::size_t j = 0; j < readings.size(); ++j) {
    const ForwardResult at = nominal_pose(mechanism, readings[j]);
    const ErrorJacobian J_e = error_jacobian(mechanism.geometry, at.pose, at.at);
    const auto row = static_cast<Eigen::Index>(3 * j);
    system.b.segment<3>(row) = pose_difference(*readings[j].measured, at.pose);
    system.A.block(row, 0, 3, geometry_columns) = J_e.leftCols(geometry_columns);
    const auto own = std::find(later.begin(), later.end(), readings[j].conditions.epoch);
    if (own != later.end()) {
      system.A.block<3, kEpochColumns>(
          row, geometry_columns + kEpochColumns * (own - later.begin())) = epoch_columns(J_e);
    }
    system.A.middleRows<3>(row).array().colwise() *= weight.array();
    system.b.segment<3>(row).array() *= weight.array();
  }
  for (std::size_t k = 0; k < system.parameters.size(); ++k) {
    system.A.col(static_cast<Eigen::Index>(k)) *= system.parameters[k].tolerance;
  }
  return system;
}

/// Least change: z = V_r S_r^-1 U_r' b, by A V_r = U_r S_r.
Eigen::VectorXd least_change(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                             const Identifiability& known) {
  const Eigen::MatrixXd V = known.directions.leftCols(known.rank);
  const Eigen::MatrixXd AV = A * V;
  return V * AV.householderQr().solve(b);
}

struct Solution {
  Eigen::VectorXd z;           // in tolerances, all columns
  Eigen::MatrixXd covariance;  // mm, rad
  std::vector<bool> kept;
  std::vector<LsqRound> rounds;
};

/// Solves with the columns that are kept; drops small sources and solves again while asked to.
Solution solve(const System& system, const LsqOptions& options, const Identifiability& all) {
  const auto n = static_cast<std::size_t>(system.A.cols());
  Solution s{.z = {},
             .covariance = covariance(all, system.parameters),
             .kept = std::vector<bool>(n, true),
             .rounds = {}};
  for (;;) {
    std::vector<int> columns;
    std::vector<ScaledParameter> parameters;
    for (std::size_t k = 0; k < n; ++k) {
      if (!s.kept[k]) continue;
      columns.push_back(static_cast<int>(k));
      parameters.push_back(system.parameters[k]);
    }
    const Eigen::MatrixXd A = system.A(Eigen::all, columns);
    const Identifiability known = s.rounds.empty() ? all : identifiability(A, parameters);
    const Eigen::VectorXd part = options.basic_solution ? basic_solution(A, system.b, known.rank)
                                                        : least_change(A, system.b, known);
    s.z = Eigen::VectorXd::Zero(system.A.cols());
    s.z(columns) = part;
    s.rounds.push_back({.columns = static_cast<int>(columns.size()),
                        .rank = known.rank,
                        .weighted_rss = (system.b - A * part).squaredNorm(),
                        .dropped = {}});
    if (!s.rounds.empty()) {
      s.covariance.setZero();
      s.covariance(columns, columns) = covariance(known, parameters);
    }
    std::vector<std::size_t> small;
    for (const int k : columns) {
      if (std::abs(s.z[k]) < options.drop_below) small.push_back(static_cast<std::size_t>(k));
    }
    if (small.empty() || small.size() == columns.size()) return s;
    for (const std::size_t k : small) {
      s.kept[k] = false;
      s.rounds.back().dropped.push_back(system.parameters[k].name);
    }
  }
}

void fill_robot(const Mechanism& mechanism, const System& system, const Eigen::VectorXd& values,
                LsqResult& result) {
  GeometryVector geometry = to_vector(mechanism.geometry);
  for (std::size_t k = 0; k < system.parameters.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    if (system.epochs[k] == 1) geometry[column] += values[column];
  }
  result.geometry = from_vector(geometry);
  for (std::size_t k = 0; k < system.parameters.size(); ++k) {
    if (system.epochs[k] == 1 || result.epochs.count(system.epochs[k]) > 0) continue;
    const auto first = static_cast<Eigen::Index>(k);
    result.epochs[system.epochs[k]] = {.l_zero_mm = values.segment<3>(first),
                                       .frame = Pose::from(values.segment<3>(first + 3))};
  }
}

void require_equations(Eigen::Index rows, int rank) {
  if (rows >= 3 && rows >= rank && rank > 0) return;
  throw InputError({.what = "there are not enough readings to identify anything",
                    .got = std::to_string(rows) + " equations",
                    .expected = "more equations than parameters that can be told apart",
                    .hint = "measure more points"});
}

}  // namespace

Eigen::VectorXd basic_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, int rank) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> pivoted(A);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(A.cols());
  const Eigen::VectorXd rotated = pivoted.householderQ().adjoint() * b;
  z.head(rank) = pivoted.matrixQR()
                     .topLeftCorner(rank, rank)
                     .triangularView<Eigen::Upper>()
                     .solve(rotated.head(rank));
  return pivoted.colsPermutation() * z;
}

LsqResult identify_linear(const Mechanism& mechanism, std::span<const Reading> readings,
                          const TrackerSigma& sigma, const LsqOptions& options) {
  require_sigma(sigma);
  require_equations(static_cast<Eigen::Index>(3 * readings.size()), 1);
  const System system = make_system(mechanism, readings, sigma, options);
  LsqResult result;
  result.identifiability = identifiability(system.A, system.parameters);
  require_equations(system.A.rows(), result.identifiability.rank);
  const Solution solution = solve(system, options, result.identifiability);

  Eigen::VectorXd values = solution.z;
  for (std::size_t k = 0; k < system.parameters.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    values[column] *= system.parameters[k].tolerance;
    result.parameters.push_back(
        {.parameter = system.parameters[k],
         .epoch = system.epochs[k],
         .value = values[column],
         .identified = result.identifiability.identified[k] && solution.kept[k],
         .dropped = !solution.kept[k],
         .standard_uncertainty = std::sqrt(solution.covariance(column, column))});
  }
  fill_robot(mechanism, system, values, result);
  result.covariance = solution.covariance;
  result.base = identified_combinations(result.identifiability, system.parameters,
                                        solution.covariance, values);
  result.rounds = solution.rounds;
  result.n_equations = static_cast<int>(system.A.rows());
  result.rank = solution.rounds.back().rank;
  result.weighted_rss = solution.rounds.back().weighted_rss;
  const int freedom = result.n_equations - result.rank;
  if (freedom > 0) result.sigma_ratio = std::sqrt(result.weighted_rss / freedom);
  result.words = in_words(result.identifiability, system.parameters, result.base,
                          strong_correlations(result.base, solution.covariance));
  return result;
}

}  // namespace trammel
