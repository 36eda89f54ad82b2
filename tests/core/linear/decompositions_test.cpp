#include "core/linear/decompositions.hpp"

#include <cmath>

#include "core/linear/products.hpp"
#include "core/linear/singular_values.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kRounding = 1e-12;  // of matrices of 40 columns and a condition below 1e3

MatrixXd normal(Index rows, Index columns, Random& random) {
  MatrixXd A(rows, columns);
  for (double& a : A.reshaped()) a = random.normal();
  return A;
}

/// Symmetric and positive definite, eigenvalues from 1 up.
MatrixXd positive(Index n, Random& random) {
  MatrixXd A = gram(normal(n, n, random));
  A.diagonal().array() += 1;
  return A;
}

double off(const MatrixXd& A, const MatrixXd& B) {
  REQUIRE(A.rows() == B.rows());
  REQUIRE(A.cols() == B.cols());
  return A.size() == 0 ? 0.0 : (A - B).cwiseAbs().maxCoeff();
}

MatrixXd identity(Index n) { return MatrixXd::Identity(n, n); }

}  // namespace

TEST_CASE("eigenvectors are orthonormal and bring the symmetric matrix back", "[linear]") {
  Random random(611);
  for (const Index n : {1, 2, 3, 18, 40}) {
    INFO(n);
    const MatrixXd A = positive(n, random);
    const SymmetricEigen of = symmetric_eigen(A);
    CHECK(off(gram(of.vectors), identity(n)) < 1e-13 * static_cast<double>(n));
    CHECK(off(weighted_outer(of.vectors, of.values), A) < 1e-13 * of.values[n - 1]);
    for (Index k = 1; k < n; ++k) CHECK(of.values[k - 1] <= of.values[k]);
    CHECK(std::abs(smallest_eigenvalue(A) - of.values[0]) < 1e-13 * of.values[n - 1]);
  }
  const Eigen::Matrix3d B = positive(3, random);
  const SymmetricEigen3 of = symmetric_eigen(B);
  CHECK(off(weighted_outer(of.vectors, of.values), B) < kRounding);
  CHECK(off(gram(of.vectors), identity(3)) < kRounding);
  CHECK(largest_eigenvalue((Eigen::Matrix2d() << 2, 1, 1, 2).finished()) == Approx(3));
}

TEST_CASE("Cholesky solves, inverts and counts what is positive definite", "[linear]") {
  Random random(612);
  for (const Index n : {1, 3, 18, 40}) {
    INFO(n);
    const MatrixXd A = positive(n, random), B = normal(n, 4, random);
    const Cholesky factor(A);
    REQUIRE(factor.ok());
    CHECK(off(product(A, factor.inverse()), identity(n)) < kRounding);
    CHECK(off(product(A, factor.solve(B)), B) < kRounding);
    const VectorXd b = B.col(0);
    CHECK(off(times(A, factor.solve(b)), b) < kRounding);
    CHECK(off(gram(factor.half(B)), transposed_product(B, factor.solve(B))) < kRounding);
    double log_of_all = 0;
    for (const double value : symmetric_eigen(A).values) log_of_all += std::log(value);
    CHECK(factor.log_determinant() == Approx(log_of_all).epsilon(kRounding));
    CHECK(factor.pivots().array().log().sum() == Approx(log_of_all).epsilon(kRounding));
  }
}

TEST_CASE("Cholesky refuses what is not positive definite", "[linear]") {
  CHECK_FALSE(Cholesky((MatrixXd(2, 2) << 1, 2, 2, 1).finished()).ok());
  CHECK_FALSE(Cholesky(MatrixXd::Zero(3, 3)).ok());
  CHECK_FALSE(Cholesky(-identity(4)).ok());
  CHECK(Cholesky(identity(4)).ok());
}

TEST_CASE("symmetric systems are solved, definite or not, and what is not there counts as zero",
          "[linear]") {
  Random random(613);
  for (const Index n : {1, 3, 18, 40}) {
    INFO(n);
    const MatrixXd A = positive(n, random);
    const VectorXd b = normal(n, 1, random);
    CHECK(off(times(A, solve_symmetric(A, b)), b) < kRounding);
    CHECK(off(product(A, inverse_symmetric(A)), identity(n)) < kRounding);
  }
  MatrixXd half_empty = MatrixXd::Zero(4, 4);
  half_empty.diagonal() << 4, 0, -2, 0;
  CHECK(off(product(half_empty, inverse_symmetric(half_empty)),
            (MatrixXd(4, 4) << 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0).finished()) == 0);
  CHECK(inverse_symmetric(half_empty)(1, 1) == 0);
}

TEST_CASE("square systems are solved though a pivot is zero", "[linear]") {
  Random random(614);
  for (const Index n : {2, 3, 18, 40}) {
    INFO(n);
    MatrixXd A = positive(n, random);
    A(0, 0) = 0;
    const MatrixXd B = normal(n, 3, random);
    CHECK(off(product(A, solve_square(A, B)), B) < 1e-10);
  }
  const Eigen::Matrix3d A = (Eigen::Matrix3d() << 0, 2, 1, 1, 0, 3, 4, 1, 0).finished();
  const Eigen::Vector3d b(1, -2, 5);
  CHECK(off(times(A, solve_square(A, b)), b) < kRounding);
  CHECK(off(times(A, inverse(A) * b), b) < kRounding);
  CHECK(determinant(A) == Approx(25));
  CHECK(smallest_singular_value(A) ==
        Approx(std::sqrt(smallest_eigenvalue(gram(A)))).epsilon(kRounding));
  const Eigen::Matrix3d S = positive(3, random);
  CHECK(off(times(S, solve_symmetric(S, b)), b) < kRounding);
}

TEST_CASE("least squares leave what no column can say, and the shortest share ties alike",
          "[linear]") {
  Random random(615);
  for (const Index n : {1, 3, 18, 40}) {
    INFO(n);
    const MatrixXd A = normal(3 * n, n, random);
    const VectorXd b = normal(3 * n, 1, random), x = least_squares(A, b);
    CHECK(transposed_times(A, b - times(A, x)).norm() < kRounding * A.norm());
    CHECK(off(shortest_least_squares(A, b), x) < kRounding);
    MatrixXd twice(3 * n, 2 * n);
    twice << A, A;
    const VectorXd shared = shortest_least_squares(twice, b);
    CHECK(off(shared.head(n), x / 2) < kRounding);
    CHECK(off(shared.tail(n), x / 2) < kRounding);
  }
}

TEST_CASE("an orthonormal basis spans the columns and no more", "[linear]") {
  Random random(616);
  const MatrixXd A = normal(60, 7, random), mixed = product(A, normal(7, 20, random));
  const MatrixXd U = orthonormal_basis(mixed, 1e-10);
  REQUIRE(U.cols() == 7);
  CHECK(off(gram(U), identity(7)) < kRounding);
  CHECK(without(U, A).norm() < 1e-10);
  CHECK(orthonormal_basis(MatrixXd::Zero(5, 2), 1e-10).cols() == 0);
  CHECK(orthonormal_basis(MatrixXd(5, 0), 1e-10).cols() == 0);
  MatrixXd narrow(3, 2);
  narrow << 1, 0, 0, 1e-3, 0, 0;
  CHECK(orthonormal_basis(narrow, 1e-2).cols() == 1);
  CHECK(orthonormal_basis(narrow, 1e-4).cols() == 2);
}

TEST_CASE("singular values of tall, square and wide matrices are roots of eigenvalues",
          "[linear]") {
  Random random(617);
  for (const Index rows : {0, 1, 3, 18, 60}) {
    for (const Index n : {0, 1, 3, 18}) {
      INFO(rows << " x " << n);
      const MatrixXd A = normal(rows, n, random);
      const SingularValues of = singular_values(A);
      REQUIRE(of.singular.size() == n);
      CHECK(off(gram(of.V), identity(n)) < kRounding);
      CHECK(off(gram(product(A, of.V)), MatrixXd(of.singular.cwiseAbs2().asDiagonal())) <
            kRounding * std::max(1.0, A.squaredNorm()));
      for (Index k = rows; k < n; ++k) CHECK(of.singular[k] == 0);
    }
  }
}
