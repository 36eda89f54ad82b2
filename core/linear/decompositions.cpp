#include "core/linear/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <utility>

namespace trammel {

using Eigen::MatrixXd;
using Eigen::VectorXd;

SymmetricEigen symmetric_eigen(const MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

double smallest_eigenvalue(const MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

double largest_eigenvalue(const Eigen::Matrix2d& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(A).eigenvalues()[1];
}

SymmetricEigen3 symmetric_eigen(const Eigen::Matrix3d& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

Cholesky::Cholesky(MatrixXd A) : L_(std::move(A)), ok_(false) {
  const Eigen::LLT<Eigen::Ref<MatrixXd>> in_place(L_);
  ok_ = in_place.info() == Eigen::Success;
}

double Cholesky::log_determinant() const { return 2 * L_.diagonal().array().log().sum(); }

MatrixXd Cholesky::inverse() const {
  MatrixXd X = MatrixXd::Identity(L_.rows(), L_.cols());
  L_.triangularView<Eigen::Lower>().solveInPlace(X);
  L_.triangularView<Eigen::Lower>().adjoint().solveInPlace(X);
  return X;
}

MatrixXd Cholesky::solve(const MatrixXd& B) const {
  MatrixXd X = half(B);
  L_.triangularView<Eigen::Lower>().adjoint().solveInPlace(X);
  return X;
}

VectorXd Cholesky::solve(const VectorXd& b) const {
  VectorXd x = b;
  L_.triangularView<Eigen::Lower>().solveInPlace(x);
  L_.triangularView<Eigen::Lower>().adjoint().solveInPlace(x);
  return x;
}

MatrixXd Cholesky::half(const MatrixXd& B) const {
  MatrixXd X = B;
  L_.triangularView<Eigen::Lower>().solveInPlace(X);
  return X;
}

VectorXd solve_symmetric(const MatrixXd& A, const VectorXd& b) {
  return Eigen::LDLT<MatrixXd>(A).solve(b);
}

Eigen::Vector3d solve_symmetric(const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  return Eigen::LDLT<Eigen::Matrix3d>(A).solve(b);
}

MatrixXd inverse_symmetric(const MatrixXd& A) {
  const MatrixXd I = MatrixXd::Identity(A.rows(), A.cols());
  return Eigen::LDLT<MatrixXd>(A).solve(I);
}

MatrixXd solve_square(const MatrixXd& A, const MatrixXd& B) {
  return Eigen::PartialPivLU<MatrixXd>(A).solve(B);
}

Eigen::Vector3d solve_square(const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  return Eigen::FullPivLU<Eigen::Matrix3d>(A).solve(b);
}

Eigen::Matrix3d inverse(const Eigen::Matrix3d& A) { return A.inverse(); }

double determinant(const Eigen::Matrix3d& A) { return A.determinant(); }

double smallest_singular_value(const Eigen::Matrix3d& A) {
  return Eigen::JacobiSVD<Eigen::Matrix3d>(A).singularValues()[2];
}

}  // namespace trammel
