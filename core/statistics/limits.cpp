#include "core/statistics/limits.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "core/statistics/tail.hpp"

namespace trammel {

namespace math = boost::math;

double normal_limit(double p) { return math::quantile(math::complement(math::normal(), p / 2)); }

double student_limit(double p, double degrees) {
  return math::quantile(math::complement(math::students_t(degrees), p / 2));
}

double student3_reach(double n, double p) { return std::cbrt(2.205 * n / p); }

double Kurtosis::in_errors() const {
  constexpr double kEnough = 30;  // values: of fewer the error of a kurtosis is not sqrt(24 / n)
  if (n_ < kEnough || squares_ <= 0) return 0;
  return (fourths_ * n_ / (squares_ * squares_) - 3) / std::sqrt(24 / n_);
}

double student_tail(double t, double degrees) {
  return 2 * math::cdf(math::complement(math::students_t(degrees), std::abs(t)));
}

double chi2_limit(double p, double degrees) {
  return math::quantile(math::complement(math::chi_squared(degrees), p));
}

double variance_ratio_limit(double p, double degrees, double other_degrees) {
  if (std::isinf(other_degrees)) return chi2_limit(p, degrees) / degrees;
  return math::quantile(math::complement(math::fisher_f(degrees, other_degrees), p));
}

}  // namespace trammel
