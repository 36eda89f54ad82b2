#pragma once

#include <string>

#include "core/mechanism/machine.hpp"
#include "core/plan/plan.hpp"

namespace trammel::cli {

/// "+-0": the direction each rail arrives in, 0 for as it comes. Throws UsageError.
Approach parse_approach(const std::string& text);
/// Throws UsageError for a direction of a drive that the machine has not.
void require_drives(const Approach& approach, const Machine& machine);
std::string approach_text(const Approach& approach);

}  // namespace trammel::cli
