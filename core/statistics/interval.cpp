#include "core/statistics/interval.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/statistics/limits.hpp"

namespace trammel {

namespace {

void require_pairs(std::span<const double> a, std::span<const double> b) {
  if (a.size() == b.size()) return;
  throw InputError({.what = "the points before and after do not pair",
                    .got = std::to_string(a.size()) + " and " + std::to_string(b.size())});
}

// What an interpolation leaves at its own nodes: rounding errors, of which there is no interval.
constexpr double kRounding = 1e-9;

double mean_of(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

/// Standard error of mean(a scale_a - b scale_b), squared.
double error2(std::span<const double> a, double scale_a, std::span<const double> b,
              double scale_b) {
  const auto n = static_cast<double>(a.size());
  const double mean = mean_of(a) * scale_a - mean_of(b) * scale_b;
  double squares = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    squares += std::pow(a[k] * scale_a - b[k] * scale_b - mean, 2);
  }
  return squares / (n * (n - 1));
}

double student(std::size_t n) { return student_limit(0.05, static_cast<double>(n - 1)); }

}  // namespace

std::optional<Interval> improvement_interval_pct(std::span<const double> before,
                                                 std::span<const double> after, double u_relative) {
  require_pairs(before, after);
  if (before.size() < kFewestForInterval) return std::nullopt;
  const double b = mean_of(before), a = mean_of(after);
  if (!(b > 0 && a > kRounding * b)) return std::nullopt;
  const double width = student(before.size()) *
                       std::sqrt(error2(after, 1 / a, before, 1 / b) + u_relative * u_relative);
  return Interval{100 * (1 - a / b * std::exp(width)), 100 * (1 - a / b * std::exp(-width))};
}

std::optional<Interval> paired_difference(std::span<const double> a, std::span<const double> b) {
  require_pairs(a, b);
  if (a.size() < kFewestForInterval) return std::nullopt;
  const double middle = mean_of(a) - mean_of(b);
  const double width = student(a.size()) * std::sqrt(error2(a, 1, b, 1));
  return Interval{middle - width, middle + width};
}

}  // namespace trammel
