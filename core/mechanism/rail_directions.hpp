#pragma once
// What inverse() needs of a geometry whatever the pose: taken once where many poses are asked for.

#include "core/mechanism/inverse.hpp"

namespace trammel {

struct RailDirections {
  std::array<double, kChains> cosine, sine;  // of alpha
};
RailDirections rail_directions(const Geometry& geometry);

/// inverse() of a geometry with its `rails`: the same bits.
InverseResult inverse(const Geometry& geometry, const RailDirections& rails, const Pose& pose);

}  // namespace trammel
