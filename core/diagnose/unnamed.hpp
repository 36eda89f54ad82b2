#pragma once
// Shapes without a name, held against a set that has names.

#include <optional>
#include <vector>

#include "core/diagnose/selection.hpp"

namespace trammel {

/// The shape without a name that does best in place of the whole of `best` or of one of its
/// effects, where it is another signal than those and than any two effects of the catalogue can
/// make; its score in `score`.
std::optional<Finding> best_unnamed(const ResidualSpace& space, const Library& library,
                                    const Candidate& best, const std::vector<Shape>& shapes,
                                    double& score);

}  // namespace trammel
