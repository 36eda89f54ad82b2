#pragma once
// Decompositions of dense matrices, compiled once: Eigen's, behind plain functions. Singular values
// are our own (singular_values.hpp), least squares with a rank too (least_squares.hpp).
// Proof of all: decompositions_test.cpp.

#include <Eigen/Core>

namespace trammel {

/// A = vectors diag(values) vectors', values rising, vectors' vectors = I: both within 1e-13 of the
/// largest value for 40 columns.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);
double smallest_eigenvalue(const Eigen::MatrixXd& A);
double largest_eigenvalue(const Eigen::Matrix2d& A);

struct SymmetricEigen3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};
SymmetricEigen3 symmetric_eigen(const Eigen::Matrix3d& A);

/// A = L L' of a symmetric matrix, of which the lower triangle is read.
class Cholesky {
 public:
  explicit Cholesky(Eigen::MatrixXd A);

  /// False: A is not positive definite, and nothing below may be asked.
  [[nodiscard]] bool ok() const { return ok_; }
  /// Squares of L's diagonal: what is left of A_kk by the columns before.
  [[nodiscard]] Eigen::VectorXd pivots() const { return L_.diagonal().cwiseAbs2(); }
  [[nodiscard]] double log_determinant() const;
  [[nodiscard]] Eigen::MatrixXd inverse() const;
  /// A^-1 B
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const;
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  /// L^-1 B, so that half' half = B' A^-1 B
  [[nodiscard]] Eigen::MatrixXd half(const Eigen::MatrixXd& B) const;

 private:
  Eigen::MatrixXd L_;  // and above the diagonal the rest of A
  bool ok_;
};

/// A^-1 b of a symmetric matrix by the pivoted A = P' L D L' P; what D lacks counts as zero.
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
Eigen::Vector3d solve_symmetric(const Eigen::Matrix3d& A, const Eigen::Vector3d& b);
Eigen::MatrixXd inverse_symmetric(const Eigen::MatrixXd& A);

/// A^-1 B of a regular matrix (partial pivoting), and of 3 x 3 (full pivoting).
Eigen::MatrixXd solve_square(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::Vector3d solve_square(const Eigen::Matrix3d& A, const Eigen::Vector3d& b);

/// Of a regular matrix, by cofactors.
Eigen::Matrix3d inverse(const Eigen::Matrix3d& A);
double determinant(const Eigen::Matrix3d& A);
double smallest_singular_value(const Eigen::Matrix3d& A);

/// min |A x - b| for columns that are independent (Householder QR).
Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// min |A x - b|, of all such x the shortest (complete orthogonal decomposition).
Eigen::VectorXd shortest_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Orthonormal columns that span A's: of its column-pivoted QR those whose pivot is beyond
/// `least` of the first. No columns for zeros.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& A, double least);

}  // namespace trammel
