#pragma once
// Numbers in sentences, where a library of text is not at hand.

#include <cstdio>
#include <string>

namespace trammel {

/// As printf does; at most 299 bytes.
template <class... Numbers>
std::string printed(const char* format, Numbers... numbers) {
  char text[300];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

}  // namespace trammel
