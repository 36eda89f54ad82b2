#pragma once

#include <string>

#include "core/plan/plan.hpp"

namespace trammel::cli {

/// "+-0": the direction each rail arrives in, 0 for as it comes. Throws UsageError.
Approach parse_approach(const std::string& text);
std::string approach_text(const Approach& approach);

}  // namespace trammel::cli
