#include "core/linear/products.hpp"

#include <algorithm>
#include <vector>

#include "core/linear/cpu_level.hpp"
#include "core/linear/lanes.hpp"

namespace trammel {

namespace {

constexpr int kPanel = 16;           // columns of A at a time, side by side in lanes
constexpr int kBeside = 4;           // columns of B at a time
constexpr Eigen::Index kDeep = 256;  // rows at a time, which stay in the cache

/// sums(i, j) += sum over rows of panel(row, i) B(row, j): row after row, whatever the lanes.
template <int n>
void add_panel(const double* panel, const double* const (&B)[kBeside], Eigen::Index rows,
               double (&sums)[kBeside][kPanel]) {
  constexpr std::size_t kVectors = kPanel / n, kWide = n;
  Real<n> sum[kBeside][kVectors];
  for (int j = 0; j < kBeside; ++j) {
    for (std::size_t v = 0; v < kVectors; ++v) sum[j][v] = load_lanes<n>(&sums[j][v * kWide]);
  }
  for (Eigen::Index row = 0; row < rows; ++row, panel += kPanel) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      const Real<n> a = load_lanes<n>(panel + v * kWide);
      for (int j = 0; j < kBeside; ++j) sum[j][v] += a * B[j][row];
    }
  }
  for (int j = 0; j < kBeside; ++j) {
    for (std::size_t v = 0; v < kVectors; ++v) store_lanes<n>(sum[j][v], &sums[j][v * kWide]);
  }
}

}  // namespace

Eigen::MatrixXd wide_transposed_product(const MatrixIn& A, const MatrixIn& B) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(A.cols(), B.cols());
  std::vector<double> packed(static_cast<std::size_t>(kDeep) * kPanel);
  at_level(cpu_level(), [&]<int n>() {
    for (Eigen::Index first = 0; first < A.rows(); first += kDeep) {
      const Eigen::Index rows = std::min(kDeep, A.rows() - first);
      for (Eigen::Index i = 0; i < A.cols(); i += kPanel) {
        const Eigen::Index wide = std::min<Eigen::Index>(kPanel, A.cols() - i);
        for (Eigen::Index row = 0; row < rows; ++row) {
          for (Eigen::Index c = 0; c < kPanel; ++c) {
            packed[static_cast<std::size_t>(row * kPanel + c)] =
                c < wide ? A(first + row, i + c) : 0;
          }
        }
        for (Eigen::Index j = 0; j < B.cols(); j += kBeside) {
          const Eigen::Index beside = std::min<Eigen::Index>(kBeside, B.cols() - j);
          const double* columns[kBeside];
          double sums[kBeside][kPanel] = {};
          for (int k = 0; k < kBeside; ++k) {
            columns[k] = B.col(j + std::min<Eigen::Index>(k, beside - 1)).data() + first;
            for (Eigen::Index c = 0; c < wide && k < beside; ++c) sums[k][c] = C(i + c, j + k);
          }
          add_panel<n>(packed.data(), columns, rows, sums);
          for (int k = 0; k < beside; ++k) {
            for (Eigen::Index c = 0; c < wide; ++c) C(i + c, j + k) = sums[k][c];
          }
        }
      }
    }
  });
  return C;
}

}  // namespace trammel
