#include "core/calibrate/lsq.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibrate/lsq_system.hpp"
#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/least_squares.hpp"
#include "core/linear/products.hpp"

namespace trammel {

namespace {

constexpr double kStill =
    1e-6;  // tolerances: a further step, as the last ones shrink, changes nothing

/// Least change: z = V_r S_r^-1 U_r' b, by A V_r = U_r S_r.
Eigen::VectorXd least_change(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                             const Identifiability& known) {
  const Eigen::MatrixXd V = known.directions.leftCols(known.rank);
  return times(V, least_squares(product(A, V), b));
}

/// Of the parameters, mm and rad: with phi's rows weighted w times too high their noise is w,
///   C A' D^2 A C,   C = covariance at unit noise, D = diag(1, 1, w) per reading.
Eigen::MatrixXd weighted_covariance(Eigen::MatrixXd A, const Identifiability& known,
                                    const std::vector<ScaledParameter>& parameters,
                                    double attitude_weight) {
  const Eigen::MatrixXd C = covariance(known, parameters);
  if (attitude_weight == 1) return C;
  for (Eigen::Index row = 2; row < A.rows(); row += 3) A.row(row) *= attitude_weight;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    A.col(static_cast<Eigen::Index>(k)) /= parameters[k].tolerance;
  }
  return gram(product(A, C));
}

struct Solution {
  Eigen::VectorXd z;           // in tolerances, all columns
  Eigen::MatrixXd directions;  // in which it may move, in tolerances, as columns
  Eigen::MatrixXd covariance;  // mm, rad
  std::vector<bool> kept;
  std::vector<LsqRound> rounds;
};

/// min |A z - b| by the square A and b of a QR: the same solutions, singular values and
/// directions; of the sum of squares `left2` is left out.
struct CompactSystem {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  double left2 = 0;
};

CompactSystem compact(const LsqSystem& system) {
  const Eigen::Index n = system.A.cols();
  const PivotedQr qr =
      pivoted_qr(system.A, system.b, static_cast<int>(std::min(n, system.A.rows())));
  CompactSystem small{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), qr.left2};
  small.A(Eigen::seqN(0, qr.R.rows()), qr.columns) = qr.R;
  small.b.head(qr.Qb.size()) = qr.Qb;
  return small;
}

/// Unit vectors of the columns that a basic solution takes.
Eigen::MatrixXd unit_vectors(const Eigen::VectorXd& z) {
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(z.size(), (z.array() != 0).count());
  Eigen::Index next = 0;
  for (Eigen::Index k = 0; k < z.size(); ++k) {
    if (z[k] != 0) directions(k, next++) = 1;
  }
  return directions;
}

/// Solves with the columns that are kept; drops small sources and solves again while asked to.
Solution solve(const LsqSystem& system, const CompactSystem& small, const LsqOptions& options,
               const Identifiability& all) {
  const auto n = static_cast<std::size_t>(system.A.cols());
  Solution s{.z = {},
             .directions = {},
             .covariance = {},
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
    const Eigen::MatrixXd A = small.A(Eigen::all, columns);
    const Identifiability known =
        s.rounds.empty() ? all : identifiability(A, parameters, all.n_poses);
    const Eigen::VectorXd part = options.basic_solution ? basic_solution(A, small.b, known.rank)
                                                        : least_change(A, small.b, known);
    s.z = Eigen::VectorXd::Zero(system.A.cols());
    s.z(columns) = part;
    const Eigen::MatrixXd moving = options.basic_solution
                                       ? unit_vectors(part)  // fewer where a value is exactly zero
                                       : Eigen::MatrixXd(known.directions.leftCols(known.rank));
    s.directions.setZero(system.A.cols(), moving.cols());
    s.directions(columns, Eigen::all) = moving;
    s.rounds.push_back({.columns = static_cast<int>(columns.size()),
                        .rank = known.rank,
                        .weighted_rss = small.left2 + (small.b - times(A, part)).squaredNorm(),
                        .dropped = {}});
    s.covariance.setZero(system.A.cols(), system.A.cols());
    s.covariance(columns, columns) = weighted_covariance(system.A(Eigen::all, columns), known,
                                                         parameters, options.attitude_weight);
    std::vector<std::size_t> dropped;
    for (const int k : columns) {
      if (std::abs(s.z[k]) < options.drop_below) dropped.push_back(static_cast<std::size_t>(k));
    }
    if (dropped.empty() || dropped.size() == columns.size()) return s;
    for (const std::size_t k : dropped) {
      s.kept[k] = false;
      s.rounds.back().dropped.push_back(system.parameters[k].name);
    }
  }
}

/// min |A z - b| with z = D y: D' A'A D y = D' A'b. Of a step of Gauss-Newton the next one makes up
/// what the normal equations lose; where all end the gradient A'b is zero either way.
Eigen::VectorXd step_within(const Eigen::MatrixXd& D, const LsqSystem& system) {
  const NormalEquations all = normal_equations(system.A, system.b);
  const Eigen::MatrixXd AtA = transposed_product(D, product(all.AtA, D));
  return times(D, solve_symmetric(AtA, transposed_times(D, all.Atb)));
}

/// From tolerances to mm and rad.
Eigen::VectorXd in_units(Eigen::VectorXd z, const std::vector<ScaledParameter>& parameters) {
  for (Eigen::Index k = 0; k < z.size(); ++k) {
    z[k] *= parameters[static_cast<std::size_t>(k)].tolerance;
  }
  return z;
}

void fill_robot(const Mechanism& mechanism, const LsqSystem& system, const Eigen::VectorXd& z,
                LsqResult& result) {
  const Eigen::VectorXd values = in_units(z, system.parameters);
  GeometryVector geometry = to_vector(mechanism.geometry);
  for (std::size_t k = 0; k < system.parameters.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    if (system.epochs[k] == 1) geometry[column] += values[column];
  }
  result.geometry = from_vector(geometry);
  result.epochs.clear();
  for (std::size_t k = 0; k < system.parameters.size(); ++k) {
    if (system.epochs[k] == 1 || result.epochs.count(system.epochs[k]) > 0) continue;
    const auto first = static_cast<Eigen::Index>(k);
    result.epochs[system.epochs[k]] = {.l_zero_mm = values.segment<3>(first),
                                       .frame = Pose::from(values.segment<3>(first + 3))};
  }
}

/// Sum of squares per reading of the coordinates of position and of attitude, as standard
/// deviations: 1 and 1 where noise explains all and many readings share few parameters.
void fill_residuals(const LsqSystem& system, const Eigen::VectorXd& z, double attitude_weight,
                    LsqResult& result) {
  const Eigen::VectorXd left = system.b - times(system.A, z);
  result.weighted_rss = left.squaredNorm();
  double position = 0, attitude = 0;
  for (Eigen::Index row = 0; row < left.size(); row += 3) {
    position += left.segment<2>(row).squaredNorm();
    attitude += std::pow(left[row + 2] / attitude_weight, 2);
  }
  const double n = static_cast<double>(left.size()) / 3;
  result.position_rms_sigma = std::sqrt(position / (2 * n));
  result.attitude_rms_sigma = std::sqrt(attitude / n);
  result.chi2 = position + attitude;
  const int freedom = result.n_equations - result.rank;
  result.sigma_ratio = freedom > 0 ? std::sqrt(result.chi2 / freedom) : 0;
}

void require_equations(Eigen::Index rows, int rank) {
  if (rows >= 3 && rows >= rank && rank > 0) return;
  throw InputError({.what = "there are not enough readings to identify anything",
                    .got = std::to_string(rows) + " equations",
                    .expected = "more equations than parameters that can be told apart",
                    .hint = "measure more points"});
}

}  // namespace

Eigen::VectorXd LsqResult::values() const {
  Eigen::VectorXd all(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    all[static_cast<Eigen::Index>(k)] = parameters[k].value;
  }
  return all;
}

LsqResult identify_repeated(const Mechanism& mechanism, std::span<const Reading> readings,
                            const TrackerSigma& sigma, const LsqOptions& options, int steps) {
  require_equations(static_cast<Eigen::Index>(3 * readings.size()), 1);
  LsqSystem system = lsq_system(mechanism, readings, sigma, options);
  const CompactSystem small = compact(system);
  LsqResult result;
  result.identifiability =
      identifiability(small.A, system.parameters, static_cast<int>(readings.size()));
  require_equations(system.A.rows(), result.identifiability.rank);
  const Solution solution = solve(system, small, options, result.identifiability);
  result.covariance = solution.covariance;
  result.rounds = solution.rounds;
  result.n_equations = static_cast<int>(system.A.rows());
  result.rank = solution.rounds.back().rank;

  const Eigen::MatrixXd& D = solution.directions;
  Eigen::VectorXd z = solution.z, total = z;
  double previous = 0;
  for (;;) {
    fill_robot(mechanism, system, total, result);
    fill_residuals(system, z, options.attitude_weight, result);
    const double size = z.cwiseAbs().maxCoeff();
    const double next = previous > 0 ? size * std::min(1.0, size / previous) : size;
    if (result.steps >= steps || next < kStill) break;
    previous = size;
    Mechanism at = mechanism;
    at.geometry = result.geometry;
    linearise(system, at, readings, sigma, options, result.epochs);
    z = step_within(D, system);
    total += z;
    ++result.steps;
  }
  const Eigen::VectorXd values = in_units(total, system.parameters);
  for (std::size_t k = 0; k < system.parameters.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    result.parameters.push_back(
        {.parameter = system.parameters[k],
         .epoch = system.epochs[k],
         .value = values[column],
         .identified = result.identifiability.identified[k] && solution.kept[k],
         .dropped = !solution.kept[k],
         .standard_uncertainty = std::sqrt(solution.covariance(column, column))});
  }
  return result;
}

LsqResult identify_linear(const Mechanism& mechanism, std::span<const Reading> readings,
                          const TrackerSigma& sigma, const LsqOptions& options) {
  return identify_repeated(mechanism, readings, sigma, options, 1);
}

}  // namespace trammel
