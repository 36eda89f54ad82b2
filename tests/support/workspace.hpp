#pragma once
// Seeded poses and geometries for sweeps.

#include "core/mechanism/geometry.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"

namespace trammel::tests {

/// Uniform in |x|, |y| <= 100 mm, |phi| <= 12 deg: the workspace the paper measures, and more.
inline Pose random_pose(Random& random) {
  return {random.uniform(-100, 100), random.uniform(-100, 100),
          rad_from_deg(random.uniform(-12, 12))};
}

/// The paper's robot with machining errors `times` the tolerance, rail offsets included.
inline Geometry random_geometry(Random& random, double times = 1) {
  GeometryVector v = to_vector(paper_mechanism().geometry);
  for (int k = 0; k < kGeometryParameters; ++k) {
    v[k] += times * random.normal() * geometry_parameters()[static_cast<std::size_t>(k)].tolerance;
  }
  return from_vector(v);
}

}  // namespace trammel::tests
