#include "core/statistics/limits.hpp"

#include <cmath>

#include "core/error.hpp"

namespace trammel {

namespace {

/// x in [0, high] where the falling `tail` passes p.
template <class Tail>
double where_tail_is(double p, double high, const Tail& tail) {
  TRAMMEL_ASSERT(p > 0 && p < 1);
  double low = 0;
  for (;;) {
    const double middle = (low + high) / 2;
    if (middle == low || middle == high) return high;  // no number is between them
    (tail(middle) > p ? low : high) = middle;
  }
}

}  // namespace

double normal_limit(double p) {
  return where_tail_is(p, 40, [](double z) { return std::erfc(z / std::sqrt(2.0)); });
}

double student_limit(double p, double degrees) {
  const double z = normal_limit(p);
  return z + (z * z * z + z) / (4 * degrees) +
         (5 * std::pow(z, 5) + 16 * z * z * z + 3 * z) / (96 * degrees * degrees);
}

double chi2_of_three_limit(double p) {
  return where_tail_is(p, 1500, [](double x) {
    return std::erfc(std::sqrt(x / 2)) + std::sqrt(2 * x / M_PI) * std::exp(-x / 2);
  });
}

double variance_ratio_limit(double p, double degrees, double other_degrees) {
  const double z = normal_limit(2 * p);
  const double a = 2 / (9 * degrees), b = 2 / (9 * other_degrees);
  // ((1 - b) g - (1 - a))^2 = z^2 (b g^2 + a), g = F^(1/3), the larger root
  const double q2 = (1 - b) * (1 - b) - z * z * b;
  if (q2 <= 0) return std::numeric_limits<double>::infinity();
  const double q1 = (1 - a) * (1 - b), q0 = (1 - a) * (1 - a) - z * z * a;
  const double g = (q1 + std::sqrt(q1 * q1 - q2 * q0)) / q2;
  return g * g * g;
}

}  // namespace trammel
