#pragma once

#include <string>
#include <vector>

#include "core/plan/build.hpp"

namespace trammel {

/// The groups of poses a plan can be asked for by name: "paper-80", "paper-48",
/// "paper-48-farthest", "circles". Throws UsageError that lists the names.
std::vector<TargetGroup> named_groups(const std::string& name);

const std::vector<std::string>& grid_names();

/// The named grid as a plan of that name, in the order listed, as it comes, at phi = 0.
Plan named_plan(const std::string& name, ReadingSet set = ReadingSet::identify);

}  // namespace trammel
