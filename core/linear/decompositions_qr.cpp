// Those of decompositions.hpp that rest on Householder reflections: apart, since each half takes
// the compiler as long as most folders.
#include <Eigen/QR>

#include "core/linear/decompositions.hpp"

namespace trammel {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd least_squares(const MatrixXd& A, const VectorXd& b) {
  return Eigen::HouseholderQR<MatrixXd>(A).solve(b);
}

VectorXd shortest_least_squares(const MatrixXd& A, const VectorXd& b) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(A).solve(b);
}

MatrixXd orthonormal_basis(const MatrixXd& A, double least) {
  if (A.cols() == 0) return A;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(A);
  const VectorXd pivots = qr.matrixQR().diagonal().cwiseAbs();
  const double largest = pivots.size() > 0 ? pivots[0] : 0;
  const Eigen::Index rank = largest > 0 ? (pivots.array() > least * largest).count() : 0;
  return qr.householderQ() * MatrixXd::Identity(A.rows(), rank);
}

}  // namespace trammel
