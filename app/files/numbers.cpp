#include "app/files/numbers.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/units.hpp"

namespace trammel {

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  if (text.empty() || text.find_first_not_of("0123456789.eE+-") != std::string_view::npos) {
    return std::nullopt;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::optional<int> parse_integer(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

double rounded(double value, int decimals) {
  const double scale = std::pow(10.0, decimals);
  return std::round(value * scale) / scale + 0.0;
}

std::string number_text(double value) {
  if (value == 0) return "0";
  std::array<char, 64> buffer;
  const double size = std::abs(value);
  const auto format =
      size >= 1e-7 && size < 1e15 ? std::chars_format::fixed : std::chars_format::scientific;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format).ptr;
  return {buffer.data(), end};
}

namespace {

/// `value` rounded to `digits` significant decimals.
double significant(double value, int digits) {
  std::array<char, 64> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::scientific, digits - 1)
                       .ptr;
  double result = 0;
  std::from_chars(buffer.data(), end, result);
  return result;
}

}  // namespace

double exact_deg(double rad) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr int kDigits = std::numeric_limits<double>::max_digits10;
  const double near = deg_from_rad(rad);
  for (int digits = 1; digits <= kDigits; ++digits) {
    const double deg = significant(near, digits);
    if (rad_from_deg(deg) == rad) return deg;
  }
  for (const double towards : {-kInfinity, kInfinity}) {
    double deg = near;
    for (int ulp = 0; ulp < 2; ++ulp) {
      deg = std::nextafter(deg, towards);
      if (rad_from_deg(deg) == rad) return deg;
    }
  }
  return near;
}

}  // namespace trammel
