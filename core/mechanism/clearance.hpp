#pragma once

#include <array>

#include "core/mechanism/geometry.hpp"
#include "core/mechanism/inverse.hpp"

namespace trammel {

/// How close the moving parts come to each other in the plane [mm]: the least distance between the
/// centre lines of two links B_i C_i, and between a link and the platform's side that it is not
/// hinged to.
///
///   B_i = (l_i + l_zero_i - R_i) u_i + h_i n_i,   C_i = B_i + S_i (cos theta_i, sin theta_i)
/// Parts are lines: their widths belong into the clearance that is asked for. Rails and what stands
/// around the robot are not known here.
/// Precondition: `at` is the solved pose. Proof: clearance_test.cpp.
double link_clearance_mm(const Geometry& geometry, const InverseResult& at);

/// A link or cylinder between a joint of the base or its carriage, and one of the platform [mm].
struct Link {
  Eigen::Vector2d base, platform;
};
/// The same of three links.
double link_clearance_mm(const std::array<Link, kChains>& links);

}  // namespace trammel
