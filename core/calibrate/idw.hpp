#pragma once
// Inverse distance weighting of joint errors: the paper's second method.

#include <span>
#include <vector>

#include "core/calibrate/joint_error.hpp"
#include "core/linear/cpu_level.hpp"
#include "core/plane/place.hpp"

namespace trammel {

struct IdwOptions {
  double power = 2;    // weights 1 / d^power
  int neighbours = 0;  // nearest samples that count; 0 = all, as the paper
};

/// Samples as columns, so that a block of queries runs through them without a gather.
struct IdwMap {
  IdwOptions options = {};
  std::vector<double> x_mm, y_mm;           // shape (n)
  std::vector<double> e1_mm, e2_mm, e3_mm;  // shape (n)
};

/// Keeps the samples (repeats in one place as their mean). Throws InputError for no samples, a
/// power that is not positive, or more neighbours than there are places.
IdwMap fit_idw(std::span<const JointSample> samples, const IdwOptions& options = {});

/// Joint errors at a place: e = sum w_k e_k / sum w_k, w_k = 1 / d_k^power              (22)
/// over all samples or the nearest `neighbours` (equal distances: the earlier sample). A query
/// within 1e-12 mm of a sample returns the sample. Source: Zhang et al. 2024, Sec. 4.2. Proof:
/// golden numbers to 1e-12 (idw_test.cpp).
Eigen::Vector3d predict(const IdwMap& map, Place at);

/// Power (1 to 4) and neighbours (4 to 24, or all) with the least mean square of the leave-one-out
/// errors: the local variant. Of equals the first, in rising order. Throws InputError as fit_idw,
/// and for fewer than five places.
IdwOptions tune_idw(std::span<const JointSample> samples);

/// The same for many places, side by side; bit-identical to one call each, and on every level of
/// CPU where the power is whole (idw_test.cpp).
void predict(const IdwMap& map, std::span<const Place> at, std::span<Eigen::Vector3d> errors_mm,
             CpuLevel level = cpu_level());

}  // namespace trammel
