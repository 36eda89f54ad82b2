#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace trammel {

/// A decimal number and nothing else: no hexadecimal, NaN, infinity, blanks, or overflow; '.' as
/// point in every locale. None otherwise.
std::optional<double> parse_number(std::string_view text);

/// A whole number that fits an int. None otherwise.
std::optional<int> parse_integer(std::string_view text);

/// As it is printed with so many decimals, and never "-0.000".
double rounded(double value, int decimals);

/// The shortest decimal that parses back to the same double. Never "1e-05" for what a reader
/// expects as 0.00001: plain digits between 1e-7 and 1e15.
std::string number_text(double value);

/// Degrees `d` with rad_from_deg(d) == rad, the shortest such; where no double maps there, the
/// nearest. So an angle that came in as degrees leaves as the same degrees.
double exact_deg(double rad);

}  // namespace trammel
