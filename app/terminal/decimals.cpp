#include "app/terminal/decimals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace trammel::terminal {

int decimals_of(double least) {
  constexpr int kUsual = 4, kMost = 9;
  if (!(least > 0)) return kUsual;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(least))), kUsual, kMost);
}

std::string figure_text(double value) {
  const std::string text = fmt::format("{:.{}f}", value, decimals_of(std::abs(value)));
  return text.find_first_not_of("-0.") == std::string::npos && text.starts_with('-')
             ? text.substr(1)
             : text;
}

}  // namespace trammel::terminal
