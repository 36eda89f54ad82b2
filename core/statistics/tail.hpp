#pragma once
// How far the tails of distributions go, and how heavy those of a sample are.

namespace trammel {

/// P(|T| > |t|) for Student's t of `degrees` of freedom: what student_limit turns round.
/// Precondition: degrees > 0. Proof: tests/core/statistics/limits_test.cpp.
double student_tail(double t, double degrees);

/// x with P(one of `n` values |t| > x) = p for Student's t of 3 degrees of freedom, p small:
///   P(|t| > x) -> 4 sqrt(3) / (pi x^3) = 2.205 / x^3
/// Proof: tests/core/measure/screen_test.cpp counts it.
double student3_reach(double n, double p);

/// Excess kurtosis of values about 0, added one by one.
class Kurtosis {
 public:
  void add(double value) {
    const double square = value * value;
    ++n_;
    squares_ += square;
    fourths_ += square * square;
  }
  /// In its standard errors under a normal distribution, sqrt(24 / n); 0 for fewer than 30 values,
  /// where that is no error yet.
  [[nodiscard]] double in_errors() const;

 private:
  double n_ = 0, squares_ = 0, fourths_ = 0;
};

}  // namespace trammel
