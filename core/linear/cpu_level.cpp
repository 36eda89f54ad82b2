#include "core/linear/cpu_level.hpp"

#include <array>
#include <cstddef>

namespace trammel {

namespace {

constexpr const char* kBaseline =
#if defined(__x86_64__)
    "x86-64";
#elif defined(__aarch64__)
    "arm64";
#else
    "other";
#endif

CpuLevel found() {
#if defined(__x86_64__)
  // by what sets the levels apart: not every compiler knows their names
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") ||
      !__builtin_cpu_supports("bmi2")) {
    return CpuLevel::x86_64;
  }
  const bool v4 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return v4 ? CpuLevel::x86_64_v4 : CpuLevel::x86_64_v3;
#else
  return CpuLevel::x86_64;
#endif
}

}  // namespace

CpuLevel cpu_level() {
  static const CpuLevel level = found();
  return level;
}

const char* name_of(CpuLevel level) {
  constexpr std::array<const char*, 3> kNames = {kBaseline, "x86-64-v3", "x86-64-v4"};
  return kNames[static_cast<std::size_t>(level)];
}

}  // namespace trammel
