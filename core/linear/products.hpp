#pragma once
// Products of matrices, compiled once: each expression of Eigen would compile its own kernels.

#include <Eigen/Core>

namespace trammel {

using MatrixIn = Eigen::Ref<const Eigen::MatrixXd>;
using VectorIn = Eigen::Ref<const Eigen::VectorXd>;
using Rows3In = Eigen::Ref<const Eigen::Matrix3Xd>;  // three rows of a larger matrix too

// Exact where all sums are, as of whole numbers, for any size: products_test.cpp.

/// A B
Eigen::MatrixXd product(const MatrixIn& A, const MatrixIn& B);
/// A' B
Eigen::MatrixXd transposed_product(const MatrixIn& A, const MatrixIn& B);
/// A' B of many columns, in the widest instructions that the machine has; the same bits on each.
Eigen::MatrixXd wide_transposed_product(const MatrixIn& A, const MatrixIn& B);
/// A B'
Eigen::MatrixXd product_transposed(const MatrixIn& A, const MatrixIn& B);
/// A' A
Eigen::MatrixXd gram(const MatrixIn& A);
/// M += factor A' A
void add_gram(Eigen::MatrixXd& M, const MatrixIn& A, double factor);
/// V diag(weights) V'
Eigen::MatrixXd weighted_outer(const MatrixIn& V, const VectorIn& weights);
/// A B' of three rows each, column after column
Eigen::Matrix3d rows_product(const Rows3In& A, const Rows3In& B);

/// A x
Eigen::VectorXd times(const MatrixIn& A, const VectorIn& x);
/// A' x
Eigen::VectorXd transposed_times(const MatrixIn& A, const VectorIn& x);

/// What the orthonormal columns of U say of x, U (U' x), and what they leave, X - U (U' X).
Eigen::VectorXd within(const MatrixIn& U, const VectorIn& x);
Eigen::MatrixXd without(const Eigen::MatrixXd& U, const Eigen::MatrixXd& X);
Eigen::VectorXd without(const Eigen::MatrixXd& U, const Eigen::VectorXd& x);

}  // namespace trammel
