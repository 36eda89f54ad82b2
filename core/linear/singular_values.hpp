#pragma once
// Singular values, pairs of columns side by side.

#include <Eigen/Core>

#include "core/linear/cpu_level.hpp"

namespace trammel {

/// A = U diag(singular) V'
struct SingularValues {
  Eigen::VectorXd singular;  // falling
  Eigen::MatrixXd V;         // right singular vectors as columns, orthonormal, (n, n)
};

/// Of any matrix, by a column-pivoted QR: as many singular values as columns, zeros where rows are
/// fewer. Against Eigen's QR and JacobiSVD of its R: 17 us for 48 of 240 x 18, 26 for 68 of 240 x
/// 21 and 211 for 788 of 720 x 40, which is why it is the only one here. Proof:
/// decompositions_test.cpp.
SingularValues singular_values(const Eigen::MatrixXd& A);

/// Of the square R of a column-pivoted QR. One-sided Jacobi on R' (Golub and Van Loan, Matrix
/// Computations, 4th ed., Sec. 8.6.3), whose columns such a QR leaves nearly orthogonal (Drmac and
/// Veselic, SIAM J. Matrix Anal. Appl. 29, 2008), pairs side by side in the odd-even order (Luk and
/// Park, SIAM J. Sci. Stat. Comput. 10, 1989):
///   R' J = V diag(singular)
/// Rows of R no longer than n eps of the first are rounding: they count as zero, and so do as many
/// singular values. Reflections that make a triangle of what is left (Sec. 5.4) hold the null
/// space. Within 2 n eps: singular values, of the largest, and of themselves too where R is a well
/// conditioned matrix whose rows are scaled; V' V = I. The bits are the same on every level of CPU.
/// Proof: singular_values_test.cpp.
SingularValues singular_values_of_triangle(const Eigen::MatrixXd& R, CpuLevel level = cpu_level());

}  // namespace trammel
