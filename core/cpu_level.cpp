#include "core/cpu_level.hpp"

#include <array>
#include <cstddef>

namespace trammel {

namespace {

CpuLevel found() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("x86-64-v4")) return CpuLevel::x86_64_v4;
  if (__builtin_cpu_supports("x86-64-v3")) return CpuLevel::x86_64_v3;
#endif
  return CpuLevel::x86_64;
}

}  // namespace

CpuLevel cpu_level() {
  static const CpuLevel level = found();
  return level;
}

const char* name_of(CpuLevel level) {
  constexpr std::array<const char*, 3> kNames = {"x86-64", "x86-64-v3", "x86-64-v4"};
  return kNames[static_cast<std::size_t>(level)];
}

}  // namespace trammel
