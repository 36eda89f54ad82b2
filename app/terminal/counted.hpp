#pragma once

#include <string>
#include <string_view>

namespace trammel::terminal {

/// "1 point", "48 points". Proof: text_test.cpp.
template <class Number>
std::string counted(Number n, std::string_view what) {
  return std::to_string(n) + " " + std::string(what) + (n == 1 ? "" : "s");
}

}  // namespace trammel::terminal
