#pragma once
// A network of Gaussian neurons over the plane: the paper's third method.

#include <cstdint>
#include <span>
#include <vector>

#include "core/calibrate/idw.hpp"
#include "core/calibrate/joint_error.hpp"

namespace trammel {

/// e(p) = bias + sum_j w_j exp(-|p - c_j|^2 / sigma_j^2)                                   (23, 24)
struct RbfNetwork {
  Eigen::ArrayXd cx_mm, cy_mm, sigma_mm;                // shape (neurons)
  Eigen::Matrix<double, Eigen::Dynamic, 3> weights_mm;  // shape (neurons, 3)
  Eigen::Vector3d bias_mm = Eigen::Vector3d::Zero();
  double relative_ridge = 0;  // it was trained with: tells how it follows its samples
};

/// Joint errors at a place. Proof: golden numbers to 1e-12 (rbf_test.cpp).
Eigen::Vector3d predict(const RbfNetwork& network, Place at);

/// The same for many places, side by side; bit-identical to one call each, and on every level of
/// CPU (rbf_test.cpp).
void predict(const RbfNetwork& network, std::span<const Place> at,
             std::span<Eigen::Vector3d> errors_mm, CpuLevel level = cpu_level());

struct RbfOptions {
  int neurons = 50;
  std::uint64_t seed = 1;        // of the k-means start
  double relative_ridge = 1e-8;  // times the mean diagonal of Phi' Phi; the bias is not penalised
  double sigma_mm = 0;           // 0: chosen by leave-one-out over the grid
};

/// One common spread that was tried: root mean square of the leave-one-out residuals, mm.
struct SpreadTrial {
  double sigma_mm = 0;
  double loo_rms_mm = 0;
};

struct RbfTraining {
  RbfNetwork network;
  double sigma_mm = 0;
  std::vector<SpreadTrial> trials;  // the whole grid, in order; empty when sigma was given
  bool at_grid_end = false;         // the best spread is the smallest or the largest tried
  int kmeans_iterations = 0;
};

/// Trains the network: centres by k-means (k-means++ start from `seed`, Lloyd until nothing moves),
/// weights with bias by ridge least squares, one common sigma by the exact leave-one-out residuals
/// r_i / (1 - h_ii), centres held, over kSpreadGridSize values from 10 to 640 mm in equal ratios.
/// Never more neurons than places. Throws InputError for fewer than two places or bad options.
/// Source: Zhang et al. 2024, Sec. 4.3. Proof: recovers a network's outputs on unseen places, the
/// leave-one-out shortcut equals leaving out (rbf_test.cpp). Deterministic for a seed.
RbfTraining train_rbf(std::span<const JointSample> samples, const RbfOptions& options = {});

inline constexpr int kSpreadGridSize = 25;
std::vector<double> spread_grid_mm();

}  // namespace trammel
