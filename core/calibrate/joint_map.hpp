#pragma once
// Any map from a place in the plane to the three joint errors there.

#include <span>
#include <string>
#include <variant>

#include "core/calibrate/gp.hpp"
#include "core/calibrate/idw.hpp"
#include "core/calibrate/rbf.hpp"

namespace trammel {

using JointMap = std::variant<IdwMap, RbfNetwork, GpMap>;

inline Eigen::Vector3d joint_error_at(const JointMap& map, Place at) {
  return std::visit([at](const auto& m) { return predict(m, at); }, map);
}

}  // namespace trammel
