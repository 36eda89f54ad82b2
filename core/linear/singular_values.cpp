#include "core/linear/singular_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/linear/lanes.hpp"
#include "core/linear/least_squares.hpp"

namespace trammel {

namespace {

using Eigen::Index;

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr int kMostSweeps = 40;  // some five are enough

template <int n>
Real<n> root(const Real<n>& x) {
  return each(x, [](double lane) { return std::sqrt(lane); });
}
template <int n>
Real<n> magnitude(const Real<n>& x) {
  return x < 0.0 ? -x : x;
}

Index whole_lanes(Index count) { return (count + kPartialSums - 1) / kPartialSums * kPartialSums; }

/// Columns side by side, row by row: those of even place, then those of odd place, so that the
/// pairs (0, 1), (2, 3), … stand side by side, and the pairs (1, 2), (3, 4), … too. Each part
/// ends in columns of zeros.
struct Columns {
  explicit Columns(Index n)
      : count(n),
        rows(n + n % 2),
        half(whole_lanes((n + 1) / 2) + kPartialSums),
        values(Eigen::MatrixXd::Zero(2 * half, rows + 1)) {}
  Eigen::MatrixXd::RowXpr column(Index j) { return values.row(j % 2 * half + j / 2); }
  double length2(Index j) { return column(j)[rows]; }

  Index count, rows, half;
  Eigen::MatrixXd values;  // after the last row |x|^2
};

template <int n>
void sum_squares(Columns& of) {
  for (Index k = 0; k < of.values.rows(); k += n) {
    Real<n> sum = {};
    for (Index i = 0; i < of.rows; ++i) {
      const Real<n> x = load_lanes<n>(&of.values(k, i));
      sum += x * x;
    }
    store_lanes<n>(sum, &of.values(k, of.rows));
  }
}

/// Turns each x and its y in their plane until they are orthogonal, and lets them change places:
///   (x, y) <- (s x + c y, c x - s y),   s / c = tan,   tan^2 + tan (|y|^2 - |x|^2) / x'y = 1
/// `carried` becomes the largest |tan| times longer over shorter: as much of another cosine comes
/// into a pair that was orthogonal already.
template <int n>
void turn(const Columns& of, double* x, double* y, Index pairs, Real<n>& carried) {
  const Index step = 2 * of.half, end = of.rows * step;
  Real<n> place;
  for (int j = 0; j < n; ++j) place[j] = j;
  for (; pairs > 0; pairs -= n, x += n, y += n) {
    Real<n> even = {}, odd = {};
    for (Index i = 0; i < end; i += 2 * step) {
      even += load_lanes<n>(x + i) * load_lanes<n>(y + i);
      odd += load_lanes<n>(x + i + step) * load_lanes<n>(y + i + step);
    }
    const Real<n> xx = load_lanes<n>(x + end), yy = load_lanes<n>(y + end), xy = even + odd,
                  d = yy - xx;
    const Real<n> lengths = root<n>(xx * yy);
    const auto oblique = magnitude<n>(xy) > (static_cast<double>(of.rows) * kEps) * lengths;
    const Real<n> opposite = oblique ? (d < 0.0 ? -2.0 * xy : 2.0 * xy) : 0.0;
    const Real<n> adjacent = oblique ? magnitude<n>(d) + root<n>(d * d + opposite * opposite) : 1.0;
    const Real<n> tan = opposite / adjacent, moved = tan * xy, left = xx - moved;
    const Real<n> inverse = 1.0 / root<n>(adjacent * adjacent + opposite * opposite);
    const auto alone = place >= static_cast<double>(pairs);  // x without a y, and zeros
    const Real<n> c = alone ? 0.0 : adjacent * inverse, s = alone ? 1.0 : opposite * inverse;
    for (Index i = 0; i < end; i += step) {
      const Real<n> xi = load_lanes<n>(x + i), yi = load_lanes<n>(y + i);
      store_lanes<n>(s * xi + c * yi, x + i);
      store_lanes<n>(c * xi - s * yi, y + i);
    }
    store_lanes<n>(alone ? xx : yy + moved, x + end);
    store_lanes<n>(alone ? yy : (left < 0.0 ? 0.0 : left), y + end);
    const Real<n> most = magnitude<n>(tan) * (d < 0.0 ? xx : yy) / lengths;
    carried = most > carried ? most : carried;
  }
}

template <int n>
void make_orthogonal(Columns& columns) {
  double* const even = columns.values.data();
  double* const odd = even + columns.half;
  double most = 1;
  // a cosine is at most twice what its turn carries, so what came back into a pair is rounding
  for (int sweep = 0; most * most > kEps; ++sweep) {
    TRAMMEL_ASSERT(sweep < kMostSweeps);
    sum_squares<n>(columns);
    Real<n> carried = {};
    for (Index k = 0; k < columns.count; ++k) {
      if (k % 2 == 0) turn<n>(columns, even, odd, columns.count / 2, carried);
      if (k % 2 == 1) turn<n>(columns, odd, even + 1, (columns.count - 1) / 2, carried);
    }
    most = 0;
    for (int j = 0; j < n; ++j) most = std::max(most, carried[j]);
  }
}

/// (I - v v') X on rows k and first, first + 1, … of X, which are columns of `rows`.
template <int n>
void reflect(Eigen::MatrixXd& rows, Index k, Index first, const double* v) {
  for (Index j = 0; j < rows.rows(); j += n) {
    Real<n> along = v[0] * load_lanes<n>(&rows(j, k));
    for (Index i = first; i < rows.cols(); ++i)
      along += v[1 + i - first] * load_lanes<n>(&rows(j, i));
    store_lanes<n>(load_lanes<n>(&rows(j, k)) - v[0] * along, &rows(j, k));
    for (Index i = first; i < rows.cols(); ++i) {
      store_lanes<n>(load_lanes<n>(&rows(j, i)) - v[1 + i - first] * along, &rows(j, i));
    }
  }
}

}  // namespace

SingularValues singular_values(const Eigen::MatrixXd& A) {
  const Index n = A.cols();
  if (n == 0) return {};
  // A = Q R P': the singular values of A are those of R, and V of A is P V of R
  const PivotedQr qr =
      pivoted_qr(A, Eigen::VectorXd::Zero(A.rows()), static_cast<int>(std::min(A.rows(), n)));
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);
  R.topRows(qr.R.rows()) = qr.R;
  SingularValues of = singular_values_of_triangle(R);
  Eigen::MatrixXd V(n, n);
  for (Index k = 0; k < n; ++k) V.row(qr.columns[static_cast<std::size_t>(k)]) = of.V.row(k);
  of.V = std::move(V);
  return of;
}

SingularValues singular_values_of_triangle(const Eigen::MatrixXd& R, CpuLevel level) {
  TRAMMEL_ASSERT(R.rows() == R.cols() && R.rows() > 0 && R.allFinite());
  const Index n = R.rows();
  const double rounding = static_cast<double>(n) * kEps * R.row(0).norm();
  Index r = 0;
  while (r < n && R.row(r).norm() > rounding) ++r;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(whole_lanes(n), n);  // of R', then of V
  rows.topRows(r) = R.topRows(r);
  Eigen::MatrixXd v(1 + n - r, r < n ? r : 0);
  Columns columns(r);
  at_level(level, [&]<int l>() {
    for (Index k = v.cols(); k-- > 0;) {
      v.col(k) << rows(k, k), rows.row(k).tail(n - r).transpose();
      v(0, k) += std::copysign(v.col(k).norm(), v(0, k));
      v.col(k) *= std::sqrt(2.0) / v.col(k).norm();
      reflect<l>(rows, k, r, &v(0, k));
    }
    for (Index j = 0; j < r; ++j) columns.column(j).head(r) = rows.row(j).head(r);
    make_orthogonal<l>(columns);
  });
  std::vector<Index> order(static_cast<std::size_t>(r));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(
      order, [&](Index a, Index b) { return columns.length2(a) > columns.length2(b); });
  Eigen::VectorXd singular = Eigen::VectorXd::Zero(n);
  rows.setZero();
  for (Index k = 0; k < r; ++k) {
    const Index j = order[static_cast<std::size_t>(k)];
    singular[k] = std::sqrt(columns.length2(j));
    TRAMMEL_ASSERT(singular[k] > 0);
    rows.row(k).head(r) = columns.column(j).head(r) / singular[k];
  }
  rows.block(r, r, n - r, n - r).setIdentity();
  at_level(level, [&]<int l>() {
    for (Index k = 0; k < v.cols(); ++k) reflect<l>(rows, k, r, &v(0, k));
  });
  return {.singular = singular, .V = rows.topRows(n).transpose()};
}

}  // namespace trammel
