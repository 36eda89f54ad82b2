#pragma once
// Least squares of small dense systems, rows side by side.

#include <Eigen/Core>
#include <vector>

#include "core/linear/cpu_level.hpp"

namespace trammel {

/// The first reflections of a column-pivoted QR of [A | b]: of the columns `columns[0]`, … in that
/// order, Q' A = R and Q' b = Qb in the rows that are done; the rest of Q' b has length
/// sqrt(left2).
struct PivotedQr {
  Eigen::MatrixXd R;   // as many rows as were done, one column per column of A, upper triangular
  Eigen::VectorXd Qb;  // of those rows
  std::vector<int> columns;
  double left2 = 0;
};

/// Column-pivoted Householder QR (Golub and Van Loan, Sec. 5.5), `rank` reflections of it, the rows
/// side by side; the lengths that pivoting compares are summed anew after each reflection, not
/// updated. Columns that are left with length zero are not taken, though `rank` asks for them. The
/// bits are the same on every level of CPU. Proof: lsq_test.cpp.
PivotedQr pivoted_qr(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, int rank,
                     CpuLevel level = cpu_level());

/// Basic solution of min |A z - b|: the `rank` columns that pivoting takes, the others stay zero.
Eigen::VectorXd basic_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, int rank,
                               CpuLevel level = cpu_level());

/// A' A z = A' b, the normal equations of min |A z - b|.
struct NormalEquations {
  Eigen::MatrixXd AtA;
  Eigen::VectorXd Atb;
};

/// A tenth of the work of a QR, at the square of its condition: for steps that a next one corrects.
/// The bits are the same on every level of CPU. Proof: lsq_test.cpp.
NormalEquations normal_equations(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                 CpuLevel level = cpu_level());

}  // namespace trammel
