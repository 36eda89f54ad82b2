#pragma once
// Made by licenses.cmake from the Debian packages that the program is built with.

#include <string_view>
#include <vector>

namespace trammel::cli {

struct LicenseText {
  std::string_view name, version, terms;
};
const std::vector<LicenseText>& license_texts();

extern const std::string_view kOwnTerms;

}  // namespace trammel::cli
