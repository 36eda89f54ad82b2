#include "core/measure/epochs.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/error.hpp"
#include "core/linear/least_squares.hpp"
#include "core/mechanism/forward.hpp"
#include "core/statistics/limits.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr int kHighestDegree = 4;
constexpr int kReadingsPerTerm = 4;  // as many again for the noise, and more
constexpr double kRankShare = 1e-9;  // of the longest column: what is shorter is rounding
constexpr double kSameMm = 1e-6;     // a coordinate that varies less is one value

/// Powers of up to three coordinates with a sum of at most `degree`.
int n_terms(int coordinates, int degree) {
  int terms = 1;  // (degree + coordinates) choose coordinates
  for (int k = 1; k <= coordinates; ++k) terms = terms * (degree + k) / k;
  return terms;
}

/// Coordinates that vary, each from -1 to 1, shape (n, coordinates).
Eigen::MatrixXd scaled_places(std::span<const Reading> readings) {
  Eigen::MatrixXd all(static_cast<Eigen::Index>(readings.size()), 3);
  for (std::size_t j = 0; j < readings.size(); ++j) {
    all.row(static_cast<Eigen::Index>(j)) = readings[j].target.vector().transpose();
  }
  Eigen::Index n = 0;
  for (Eigen::Index c = 0; c < 3; ++c) {
    const double low = all.col(c).minCoeff(), high = all.col(c).maxCoeff();
    if (high - low < kSameMm) continue;
    all.col(n++) = (2 * all.col(c).array() - low - high) / (high - low);
  }
  return all.leftCols(n);
}

/// Monomials of degree 0 … `degree`, one column each, shape (n, n_terms).
Eigen::MatrixXd monomials(const Eigen::MatrixXd& places, int degree) {
  const int coordinates = static_cast<int>(places.cols());
  Eigen::MatrixXd terms(places.rows(), n_terms(coordinates, degree));
  Eigen::Index next = 0;
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; b <= (coordinates > 1 ? degree - a : 0); ++b) {
      for (int c = 0; c <= (coordinates > 2 ? degree - a - b : 0); ++c) {
        Eigen::ArrayXd term = Eigen::ArrayXd::Ones(places.rows());
        const int powers[3] = {a, b, c};
        for (int k = 0; k < coordinates; ++k) {
          for (int p = 0; p < powers[k]; ++p) term *= places.col(k).array();
        }
        terms.col(next++) = term;
      }
    }
  }
  return terms.leftCols(next);
}

struct Left {
  double sum_of_squares = 0;
  int rank = 0;
};

/// What min |A z - b| leaves, by the columns that are more than rounding.
Left left_by(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const PivotedQr qr = pivoted_qr(A, b, static_cast<int>(A.cols()));
  Left left{.sum_of_squares = qr.left2, .rank = 0};
  for (Eigen::Index k = 0; k < qr.R.rows(); ++k) {
    if (std::abs(qr.R(k, k)) > kRankShare * std::abs(qr.R(0, 0))) {
      ++left.rank;
    } else {
      left.sum_of_squares += qr.Qb[k] * qr.Qb[k];
    }
  }
  return left;
}

/// measured - forward(cmd), shape (n, 3).
Eigen::MatrixXd deviations(const Mechanism& mechanism, std::span<const Reading> readings) {
  Eigen::MatrixXd d(static_cast<Eigen::Index>(readings.size()), 3);
  const RailFrames rails = rail_frames(mechanism.geometry);
  for (std::size_t j = 0; j < readings.size(); ++j) {
    const ForwardResult at = forward(rails, readings[j].conditions.cmd_mm, readings[j].target);
    if (!at.ok()) {
      throw InputError({.what = "the commanded displacements are out of the nominal robot's reach",
                        .where = {.point = "seq " + std::to_string(readings[j].seq)}});
    }
    Eigen::Vector3d step = readings[j].measured->vector() - at.pose.vector();
    step[2] = std::remainder(step[2], 2 * kPi);
    d.row(static_cast<Eigen::Index>(j)) = step.transpose();
  }
  return d;
}

Eigen::MatrixXd directions(std::span<const Reading> readings) {
  Eigen::MatrixXd dir(static_cast<Eigen::Index>(readings.size()), kChains);
  for (std::size_t j = 0; j < readings.size(); ++j) {
    const Conditions& c = readings[j].conditions;
    dir.row(static_cast<Eigen::Index>(j)) = directions_of(c.cmd_mm - c.from_mm).transpose();
  }
  return dir;
}

}  // namespace

EpochTest test_epochs(const Mechanism& mechanism, std::span<const Reading> readings) {
  std::vector<Reading> measured;
  std::set<int> epochs;
  for (const Reading& r : readings) {
    if (!r.measured) continue;
    measured.push_back(r);
    epochs.insert(r.conditions.epoch);
  }
  EpochTest test{.later_epochs = std::max(0, static_cast<int>(epochs.size()) - 1)};
  if (test.later_epochs == 0) return test;
  epochs.erase(epochs.begin());
  const auto n = static_cast<int>(measured.size());
  const Eigen::MatrixXd places = scaled_places(measured);
  int degree = kHighestDegree;
  while (degree > 0 && kReadingsPerTerm * n_terms(static_cast<int>(places.cols()), degree) > n) {
    --degree;
  }
  if (degree == 0 || n <= kReadingsPerTerm * (kChains + test.later_epochs)) return test;
  const Eigen::MatrixXd smooth = monomials(places, degree);
  Eigen::MatrixXd A(n, smooth.cols() + kChains + test.later_epochs);
  A.setZero();
  A.leftCols(smooth.cols()) = smooth;
  A.middleCols(smooth.cols(), kChains) = directions(measured);
  Eigen::Index column = smooth.cols() + kChains;
  for (const int epoch : epochs) {
    for (int j = 0; j < n; ++j) {
      if (measured[static_cast<std::size_t>(j)].conditions.epoch == epoch) A(j, column) = 1;
    }
    ++column;
  }
  const Eigen::MatrixXd d = deviations(mechanism, measured);
  const Eigen::MatrixXd without_steps = A.leftCols(smooth.cols() + kChains);
  test.hold = true;
  for (int c = 0; c < 3; ++c) {
    const Left none = left_by(without_steps, d.col(c)), steps = left_by(A, d.col(c));
    const int more = steps.rank - none.rank, freedom = n - steps.rank;
    if (more <= 0 || freedom <= 0) continue;
    test.tested = true;
    const double ratio = (none.sum_of_squares - steps.sum_of_squares) / more * freedom /
                         std::max(steps.sum_of_squares, 1e-300);
    if (ratio > variance_ratio_limit(test.level / 3, more, freedom)) test.hold = false;
  }
  test.hold = test.hold && test.tested;
  return test;
}

}  // namespace trammel
