#include "app/terminal/decimals.hpp"

#include <algorithm>
#include <cmath>

namespace trammel::terminal {

int decimals_of(double least) {
  constexpr int kUsual = 4, kMost = 9;
  if (!(least > 0)) return kUsual;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(least))), kUsual, kMost);
}

}  // namespace trammel::terminal
