#include "core/linear/products.hpp"

#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Whole numbers from -4 to 4: their products and sums are exact in whatever order.
MatrixXd whole(Index rows, Index columns, Random& random) {
  MatrixXd A(rows, columns);
  for (double& a : A.reshaped()) a = static_cast<double>(random.below(9)) - 4;
  return A;
}

MatrixXd turned_over(const MatrixXd& A) {
  MatrixXd T(A.cols(), A.rows());
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = 0; i < A.rows(); ++i) T(j, i) = A(i, j);
  }
  return T;
}

MatrixXd by_loops(const MatrixXd& A, const MatrixXd& B) {
  MatrixXd C = MatrixXd::Zero(A.rows(), B.cols());
  for (Index i = 0; i < C.rows(); ++i) {
    for (Index j = 0; j < C.cols(); ++j) {
      for (Index k = 0; k < A.cols(); ++k) C(i, j) += A(i, k) * B(k, j);
    }
  }
  return C;
}

}  // namespace

TEST_CASE("products are sums of rows times columns, for any size", "[linear]") {
  Random random(601);
  for (const Index n : {0, 1, 2, 3, 5, 18, 41}) {
    for (const Index m : {1, 3, 8, 67}) {
      INFO(m << " x " << n);
      const MatrixXd A = whole(m, n, random), B = whole(n, 7, random), C = whole(m, 4, random);
      CHECK(product(A, B) == by_loops(A, B));
      CHECK(transposed_product(A, C) == by_loops(turned_over(A), C));
      CHECK(wide_transposed_product(A, C) == by_loops(turned_over(A), C));
      CHECK(product_transposed(A, turned_over(B)) == by_loops(A, B));
      CHECK(gram(A) == by_loops(turned_over(A), A));
      const VectorXd x = whole(n, 1, random), y = whole(m, 1, random);
      CHECK(MatrixXd(times(A, x)) == by_loops(A, x));
      CHECK(MatrixXd(transposed_times(A, y)) == by_loops(turned_over(A), y));
      CHECK(MatrixXd(within(A, y)) == by_loops(A, by_loops(turned_over(A), y)));
      CHECK(without(A, C) == MatrixXd(C - by_loops(A, by_loops(turned_over(A), C))));
      CHECK(without(A, y) == VectorXd(y - within(A, y)));
      const MatrixXd W = x.asDiagonal();
      CHECK(weighted_outer(A, x) == by_loops(by_loops(A, W), turned_over(A)));
      MatrixXd M = whole(n, n, random);
      const MatrixXd sum = M - 2 * gram(A);
      add_gram(M, A, -2);
      CHECK(M == sum);
    }
  }
}

TEST_CASE("a wide product adds up row after row, so that its bits are those of plain loops",
          "[linear]") {
  Random random(602);
  MatrixXd A(700, 37), B(700, 9);
  for (double& a : A.reshaped()) a = random.normal();
  for (double& b : B.reshaped()) b = random.normal();
  CHECK(wide_transposed_product(A, B) == by_loops(turned_over(A), B));
  CHECK(wide_transposed_product(A, B) !=
        MatrixXd(turned_over(A.colwise().reverse()) * MatrixXd(B.colwise().reverse())));
}

TEST_CASE("three rows out of many are multiplied where they stand", "[linear]") {
  Random random(602);
  const MatrixXd A = whole(12, 21, random), B = whole(9, 21, random);
  const MatrixXd all = by_loops(A, turned_over(B));
  for (Index i = 0; i < 12; i += 3) {
    for (Index j = 0; j < 9; j += 3) {
      CHECK(MatrixXd(rows_product(A.middleRows<3>(i), B.middleRows<3>(j))) ==
            MatrixXd(all.block(i, j, 3, 3)));
    }
  }
}
