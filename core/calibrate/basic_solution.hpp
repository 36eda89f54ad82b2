#pragma once

#include <Eigen/Core>

#include "core/cpu_level.hpp"

namespace trammel {

/// Basic solution of min |A z - b|: the `rank` columns that pivoting takes, the others stay zero.
///
/// One column-pivoted Householder QR (Golub and Van Loan, Sec. 5.5), the rows side by side; the
/// lengths that pivoting compares are summed anew after each reflection, not updated. Columns that
/// are left with length zero are not taken, though `rank` asks for them. The bits are the same on
/// every level of CPU. Proof: lsq_test.cpp.
Eigen::VectorXd basic_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, int rank,
                               CpuLevel level = cpu_level());

}  // namespace trammel
