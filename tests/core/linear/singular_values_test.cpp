#include "core/linear/singular_values.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/linear/least_squares.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd drawn(Index rows, Index columns, Random& random) {
  MatrixXd A(rows, columns);
  for (double& value : A.reshaped()) value = random.normal();
  return A;
}

/// The square R of a column-pivoted QR.
MatrixXd triangle(const MatrixXd& A) {
  const PivotedQr qr = pivoted_qr(A, VectorXd::Zero(A.rows()), static_cast<int>(A.cols()));
  MatrixXd R = MatrixXd::Zero(A.cols(), A.cols());
  R.topRows(qr.R.rows()) = qr.R;
  return R;
}

/// Columns that fall by `ratio` from first to last.
MatrixXd graded(Index n, double ratio, Random& random) {
  const double last = std::log(ratio) / static_cast<double>(std::max<Index>(n - 1, 1));
  const VectorXd sizes =
      (VectorXd::LinSpaced(n, 0, static_cast<double>(n - 1)) * last).array().exp();
  return drawn(3 * n, n, random) * sizes.asDiagonal();
}

/// By one-sided Jacobi on R', pair after pair, in long double.
SingularValues slowly(const MatrixXd& R) {
  using Wide = long double;
  Eigen::Matrix<Wide, -1, -1> W = R.transpose().cast<Wide>();
  for (int sweep = 0; sweep < 20; ++sweep) {
    for (Index p = 0; p < W.cols(); ++p) {
      for (Index q = p + 1; q < W.cols(); ++q) {
        const Wide difference = W.col(p).squaredNorm() - W.col(q).squaredNorm();
        const Wide angle = std::atan2(2 * W.col(p).dot(W.col(q)), difference) / 2;
        const Eigen::JacobiRotation<Wide> turn(std::cos(angle), -std::sin(angle));
        W.applyOnTheRight(p, q, turn);  // the longer comes first
      }
    }
  }
  return {W.colwise().norm().transpose().cast<double>(), W.colwise().normalized().cast<double>()};
}

double off_orthonormal(const MatrixXd& V) {
  return (V.transpose() * V - MatrixXd::Identity(V.cols(), V.cols())).cwiseAbs().maxCoeff();
}

/// R = U diag(singular) V' to rounding, falling, the same on each level; returns it.
SingularValues decomposed(const MatrixXd& R) {
  const SingularValues of = singular_values_of_triangle(R);
  CHECK(std::is_sorted(of.singular.begin(), of.singular.end(), std::greater<>()));
  CHECK(of.singular.minCoeff() >= 0);
  CHECK(off_orthonormal(of.V) < 3e-14);
  const VectorXd lengths = (R * of.V).colwise().norm();
  CHECK((lengths - of.singular).cwiseAbs().maxCoeff() <= 1e-13 * of.singular[0]);
  for (const CpuLevel level : levels_here()) {
    CHECK(singular_values_of_triangle(R, level).singular == of.singular);
    CHECK(singular_values_of_triangle(R, level).V == of.V);
  }
  return of;
}

}  // namespace

TEST_CASE("singular values are those in long double, small ones relatively too, for any size",
          "[calibrate]") {
  Random random(501);
  for (Index n = 1; n <= 40; ++n) {
    for (const double ratio : {1.0, 1e-4, 1e-12}) {
      INFO(n << " columns that fall to " << ratio);
      const MatrixXd R = triangle(graded(n, ratio, random));
      const VectorXd singular = decomposed(R).singular, exact = slowly(R).singular;
      CHECK((singular - exact).cwiseAbs().maxCoeff() < 1e-13 * exact[0]);
      CHECK((singular - exact).cwiseQuotient(exact).cwiseAbs().maxCoeff() < 1e-12);
    }
  }
}

TEST_CASE("right singular vectors are those in long double where singular values stand apart",
          "[calibrate]") {
  Random random(502);
  for (const Index n : {2, 5, 18, 31}) {
    INFO(n);
    const MatrixXd R = triangle(graded(n, std::pow(0.4, n), random));
    const MatrixXd cosines = (decomposed(R).V.transpose() * slowly(R).V).cwiseAbs();
    CHECK((cosines - MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("the null space of tied, empty and summed columns is Eigen's", "[calibrate]") {
  Random random(503);
  for (Index n = 4; n <= 40; ++n) {
    for (const Index rank : {Index{1}, n / 2, n - 3}) {
      INFO(n << " columns, " << rank << " of them free");
      MatrixXd A = drawn(3 * n, n, random);
      for (Index j = rank; j < n; ++j) {
        A.col(j) = static_cast<double>(j % 3 - 1) * A.col(j % rank);  // opposite, empty, equal
      }
      A.col(n - 1) = A.leftCols(rank).rowwise().sum();
      const MatrixXd R = triangle(A);
      const SingularValues of = decomposed(R);
      const Eigen::JacobiSVD<MatrixXd> svd(R, Eigen::ComputeFullV);
      const VectorXd off = of.singular - svd.singularValues();
      CHECK(off.cwiseAbs().maxCoeff() < 1e-13 * of.singular[0]);
      CHECK(of.singular[rank - 1] > 1e-10);
      CHECK(of.singular.tail(n - rank).isZero(0));
      CHECK((svd.matrixV().leftCols(rank).transpose() * of.V.rightCols(n - rank))
                .cwiseAbs()
                .maxCoeff() < 1e-13 * of.singular[0] / of.singular[rank - 1]);
    }
  }
}

TEST_CASE("equal singular values are found, and those that pivots hide", "[calibrate]") {
  Random random(504);
  for (const Index n : {2, 7, 18, 33}) {
    CHECK(decomposed(MatrixXd::Identity(n, n)).singular == VectorXd::Ones(n));
    const MatrixXd Q = drawn(n, n, random).householderQr().householderQ();
    const VectorXd equal = decomposed(triangle(3 * Q)).singular;
    CHECK((equal - VectorXd::Constant(n, 3)).cwiseAbs().maxCoeff() < 1e-13);
    // Kahan's matrix: the last pivot is many times the last singular value
    MatrixXd R = MatrixXd::Identity(n, n);
    R.triangularView<Eigen::StrictlyUpper>().setConstant(-0.6);
    for (Index k = 0; k < n; ++k) R.row(k) *= std::pow(0.8, k);
    CHECK((decomposed(R).singular - slowly(R).singular).cwiseAbs().maxCoeff() < 1e-13);
  }
}

TEST_CASE("a matrix of zeros has singular values of zero and the unit vectors", "[calibrate]") {
  for (const Index n : {1, 2, 18}) {
    const SingularValues of = decomposed(MatrixXd::Zero(n, n));
    CHECK(of.singular == VectorXd::Zero(n));
    CHECK(of.V == MatrixXd::Identity(n, n));
  }
}
