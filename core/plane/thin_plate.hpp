#pragma once
// A smooth surface through scattered values: what a map shows between its points.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/plane/place.hpp"

namespace trammel {

/// f(p) = a_0 + a_1 x + a_2 y + sum_j w_j k(|p - p_j|),   k(d) = d^2 log d
/// the surface of least bending through the values (Duchon 1977), one column each.
struct ThinPlate {
  std::vector<Place> places;  // divided by scale_mm
  Eigen::MatrixXd weights;    // shape (places + 3, columns); the last three are a_0, a_1, a_2
  double scale_mm = 1;
};

/// Through `values`, shape (places, columns). Places closer than a 24th of their extent, by a grid,
/// become their mean, so that any number of readings costs the same. None where fewer than three
/// places are left or all lie on one line.
/// Proof: meets its values, and any plane everywhere (thin_plate_test.cpp).
std::optional<ThinPlate> thin_plate(std::span<const Place> places, const Eigen::MatrixXd& values);

/// The surfaces at a place, shape (columns).
Eigen::VectorXd value_at(const ThinPlate& surface, Place at);

}  // namespace trammel
