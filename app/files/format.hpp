#pragma once

#include <string_view>

#include "app/files/fields.hpp"

namespace trammel {

/// Takes the field that says what a file is. One that is missing or another is refused with the
/// formats there are (schemas/README.md). Proof: template_test.cpp.
void take_format(Fields& top, std::string_view expected, std::string_view name = "format");

/// The largest size of a number that a person gives, on a line or in a file: nanoseconds of thirty
/// years are 1e18. What is larger is a slip of the hand, and would take 200 columns in a table.
inline constexpr double kLargestNumber = 1e18;

}  // namespace trammel
