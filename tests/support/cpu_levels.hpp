#pragma once

#include <vector>

#include "core/linear/cpu_level.hpp"

namespace trammel::tests {

/// The levels of CPU that this machine has: the baseline always.
inline std::vector<CpuLevel> levels_here() {
  std::vector<CpuLevel> all;
  for (const auto level : {CpuLevel::x86_64, CpuLevel::x86_64_v3, CpuLevel::x86_64_v4}) {
    if (level <= cpu_level()) all.push_back(level);
  }
  return all;
}

}  // namespace trammel::tests
