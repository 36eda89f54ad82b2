#pragma once
// One kernel, compiled for each level of CPU and chosen at run time.

namespace trammel {

enum class CpuLevel { x86_64, x86_64_v3, x86_64_v4 };

/// The highest level this machine has; x86_64, the baseline, on any other processor. Found once.
CpuLevel cpu_level();

/// "x86-64-v3", "x86-64-v4"; of the baseline what it was compiled for: "x86-64", "arm64".
const char* name_of(CpuLevel level);

namespace levels {

// flatten draws the kernel in, so that it is compiled for the caller's instructions. Fused
// multiply-add is left out: with it the bits would differ from level to level.
template <class Kernel>
[[gnu::flatten]] void baseline(const Kernel& kernel) {
  kernel.template operator()<2>();
}
#if defined(__x86_64__)
template <class Kernel>
[[gnu::flatten, gnu::target("avx2")]] void v3(const Kernel& kernel) {
  kernel.template operator()<4>();
}
template <class Kernel>
[[gnu::flatten, gnu::target("avx2,avx512f,avx512dq,avx512vl")]] void v4(const Kernel& kernel) {
  kernel.template operator()<8>();
}
#endif

}  // namespace levels

/// Runs `kernel`, a lambda [&]<int n>(), with n lanes (lanes.hpp) in the instructions of `level`,
/// which this machine must have. A kernel of + - * / and square roots alone gives the same bits on
/// every level (lanes_test.cpp, idw_test.cpp).
template <class Kernel>
void at_level([[maybe_unused]] CpuLevel level, const Kernel& kernel) {
#if defined(__x86_64__)
  if (level == CpuLevel::x86_64_v4) return levels::v4(kernel);
  if (level == CpuLevel::x86_64_v3) return levels::v3(kernel);
#endif
  levels::baseline(kernel);
}

}  // namespace trammel
