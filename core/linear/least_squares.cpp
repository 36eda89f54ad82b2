#include "core/linear/least_squares.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/linear/lanes.hpp"

namespace trammel {

namespace {

constexpr std::size_t kLanes = kPartialSums;

/// Of kLanes partial sums, in vectors of n: wider ones than the CPU has go through memory.
template <int n>
double total_of(const std::array<Real<n>, kLanes / n>& parts) {
  PartialSums all;
  __builtin_memcpy(&all, parts.data(), sizeof all);
  return total(all);
}

/// [A | b] with rows of zeros up to whole lanes.
Eigen::MatrixXd filled_up(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::Index lanes = kLanes, rows = (A.rows() + lanes - 1) / lanes * lanes;
  Eigen::MatrixXd filled(rows, A.cols() + 1);
  filled.topLeftCorner(A.rows(), A.cols()) = A;
  filled.col(A.cols()).head(A.rows()) = b;
  filled.bottomRows(rows - A.rows()).setZero();
  return filled;
}

/// A column of [A | b], filled up with zeros.
struct Column {
  double* values;
  double norm2;  // of the rows that no reflection has taken yet
  int of;        // its place in A
};

template <int n>
double dot(const double* a, const double* b, std::size_t first, std::size_t last) {
  std::array<Real<n>, kLanes / n> s = {};
  for (std::size_t i = first; i < last; i += kLanes) {
    for (std::size_t p = 0; p < s.size(); ++p) {
      s[p] += load_lanes<n>(a + i + n * p) * load_lanes<n>(b + i + n * p);
    }
  }
  return total_of<n>(s);
}

/// a <- a - factor v, and the squares of what is left.
template <int n>
double subtract(double* a, double factor, const double* v, std::size_t first, std::size_t last) {
  std::array<Real<n>, kLanes / n> s = {};
  for (std::size_t i = first; i < last; i += kLanes) {
    for (std::size_t p = 0; p < s.size(); ++p) {
      const Real<n> left = load_lanes<n>(a + i + n * p) - factor * load_lanes<n>(v + i + n * p);
      store_lanes<n>(left, a + i + n * p);
      s[p] += left * left;
    }
  }
  return total_of<n>(s);
}

/// Makes row k of the columns after k a row of R (returned in `R`), by the reflection that leaves
/// of column k its first entry alone:
///   a <- a - v (v' a) / (|x| (|x| + |x_k|)),   v = x + sign(x_k) |x| e_k,   x = rows k.. of k
template <int n>
void reflect(std::vector<Column>& columns, std::size_t rows, std::size_t k, Eigen::MatrixXd& R) {
  const std::size_t first = k - k % kLanes;
  const auto row = static_cast<Eigen::Index>(k);
  double* v = columns[k].values;
  const double norm = std::sqrt(columns[k].norm2), head = v[k];
  R(row, row) = head < 0 ? norm : -norm;
  v[k] = head - R(row, row);
  const double scale = 1 / (norm * (norm + std::abs(head)));
  for (std::size_t j = k + 1; j < columns.size(); ++j) {
    double* a = columns[j].values;
    const double factor = scale * dot<n>(v, a, first, rows), taken = factor * v[k];
    R(row, static_cast<Eigen::Index>(j)) = a[k] - taken;
    a[k] = taken;  // so that the row that is done becomes exactly zero
    columns[j].norm2 = subtract<n>(a, factor, v, first, rows);
  }
}

/// The longest column that is left comes to place k; b stays the last.
void pivot(std::vector<Column>& columns, std::size_t k, Eigen::MatrixXd& R) {
  std::size_t longest = k;
  for (std::size_t j = k + 1; j + 1 < columns.size(); ++j) {
    if (columns[j].norm2 > columns[longest].norm2) longest = j;
  }
  if (longest == k) return;
  std::swap(columns[k], columns[longest]);
  R.col(static_cast<Eigen::Index>(k)).swap(R.col(static_cast<Eigen::Index>(longest)));
}

}  // namespace

PivotedQr pivoted_qr(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, int rank, CpuLevel level) {
  TRAMMEL_ASSERT(A.rows() == b.size() && rank >= 0 && rank <= std::min(A.rows(), A.cols()));
  const Eigen::Index n = A.cols();
  Eigen::MatrixXd work = filled_up(A, b);
  const auto rows = static_cast<std::size_t>(work.rows());
  std::vector<Column> columns;
  columns.reserve(static_cast<std::size_t>(n) + 1);
  for (Eigen::Index j = 0; j <= n; ++j) {
    double* values = work.col(j).data();
    columns.push_back({values, dot<2>(values, values, 0, rows), static_cast<int>(j)});
  }
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(rank, n + 1);
  Eigen::Index done = 0;
  at_level(level, [&]<int n_lanes>() {
    for (; done < rank; ++done) {
      const auto k = static_cast<std::size_t>(done);
      pivot(columns, k, R);
      if (!(columns[k].norm2 > 0)) break;
      reflect<n_lanes>(columns, rows, k, R);
    }
  });
  PivotedQr qr{.R = R.topLeftCorner(done, n),
               .Qb = R.col(n).head(done),
               .columns = {},
               .left2 = columns.back().norm2};
  for (Eigen::Index k = 0; k < n; ++k) {
    qr.columns.push_back(columns[static_cast<std::size_t>(k)].of);
  }
  return qr;
}

Eigen::VectorXd basic_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, int rank,
                               CpuLevel level) {
  const PivotedQr qr = pivoted_qr(A, b, rank, level);
  const Eigen::Index n_taken = qr.R.rows();
  const Eigen::VectorXd taken = qr.R.leftCols(n_taken).triangularView<Eigen::Upper>().solve(qr.Qb);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(A.cols());
  for (Eigen::Index k = 0; k < n_taken; ++k) z[qr.columns[static_cast<std::size_t>(k)]] = taken[k];
  return z;
}

NormalEquations normal_equations(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                 CpuLevel level) {
  TRAMMEL_ASSERT(A.rows() == b.size());
  const Eigen::Index n = A.cols();
  if (A.rows() % Eigen::Index{kLanes} != 0) {
    const Eigen::MatrixXd filled = filled_up(A, b);
    return normal_equations(filled.leftCols(n), filled.col(n), level);
  }
  const auto rows = static_cast<std::size_t>(A.rows());
  NormalEquations system{Eigen::MatrixXd(n, n), Eigen::VectorXd(n)};
  at_level(level, [&]<int n_lanes>() {
    for (Eigen::Index j = 0; j < n; ++j) {
      const double* column = A.col(j).data();
      for (Eigen::Index k = 0; k <= j; ++k) {
        system.AtA(j, k) = system.AtA(k, j) = dot<n_lanes>(column, A.col(k).data(), 0, rows);
      }
      system.Atb[j] = dot<n_lanes>(column, b.data(), 0, rows);
    }
  });
  return system;
}

}  // namespace trammel
