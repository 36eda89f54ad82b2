#include "core/linear/products.hpp"

namespace trammel {

Eigen::MatrixXd product(const MatrixIn& A, const MatrixIn& B) { return A * B; }

Eigen::MatrixXd transposed_product(const MatrixIn& A, const MatrixIn& B) {
  return A.transpose() * B;
}

Eigen::MatrixXd product_transposed(const MatrixIn& A, const MatrixIn& B) {
  return A * B.transpose();
}

Eigen::MatrixXd gram(const MatrixIn& A) { return transposed_product(A, A); }

void add_gram(Eigen::MatrixXd& M, const MatrixIn& A, double factor) {
  M.noalias() += factor * A.transpose() * A;
}

Eigen::MatrixXd weighted_outer(const MatrixIn& V, const VectorIn& weights) {
  const Eigen::MatrixXd weighted = V * weights.asDiagonal();
  return product_transposed(weighted, V);
}

Eigen::Matrix3d rows_product(const Rows3In& A, const Rows3In& B) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (Eigen::Index k = 0; k < A.cols(); ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) sum(i, j) += A(i, k) * B(j, k);
    }
  }
  return sum;
}

Eigen::VectorXd times(const MatrixIn& A, const VectorIn& x) { return A * x; }

Eigen::VectorXd transposed_times(const MatrixIn& A, const VectorIn& x) { return A.transpose() * x; }

Eigen::VectorXd within(const MatrixIn& U, const VectorIn& x) {
  return times(U, transposed_times(U, x));
}

Eigen::MatrixXd without(const Eigen::MatrixXd& U, const Eigen::MatrixXd& X) {
  return X - product(U, transposed_product(U, X));
}

Eigen::VectorXd without(const Eigen::MatrixXd& U, const Eigen::VectorXd& x) {
  return x - within(U, x);
}

}  // namespace trammel
