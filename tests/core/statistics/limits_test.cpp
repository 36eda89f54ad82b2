#include "core/statistics/limits.hpp"

#include <cmath>

#include "core/calibrate/goodness.hpp"
#include "core/statistics/random.hpp"
#include "core/statistics/tail.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("limits of chance are those of printed tables", "[measure]") {
  CHECK_THAT(normal_limit(0.05), WithinAbs(1.959964, 1e-6));
  CHECK_THAT(student_limit(0.05, 1), WithinAbs(12.7062, 1e-4));
  CHECK_THAT(student_limit(0.05, 20), WithinAbs(2.08596, 1e-5));
  CHECK_THAT(student_tail(-2.08596, 20), WithinAbs(0.05, 1e-6));
  CHECK_THAT(student_tail(student_limit(1e-9, 3), 3), WithinRel(1e-9, 1e-9));
  CHECK_THAT(chi2_limit(0.05, 3), WithinAbs(7.8147, 1e-4));
  CHECK_THAT(chi2_limit(0.01, 3), WithinAbs(11.3449, 1e-4));
  CHECK_THAT(variance_ratio_limit(0.05, 10), WithinRel(18.307 / 10, 1e-4));
  CHECK_THAT(variance_ratio_limit(0.001, 100), WithinRel(149.449 / 100, 1e-5));
  CHECK_THAT(variance_ratio_limit(0.05, 5, 10), WithinAbs(3.3258, 1e-4));
  CHECK_THAT(variance_ratio_limit(0.001, 20, 20), WithinAbs(4.290, 1e-3));
  CHECK(variance_ratio_limit(0.001, 200, 1) > 1e5);  // one repeat judges nothing
}

TEST_CASE("residuals of the noise alone are called unexplained in no more than 1 of 1000 fits",
          "[measure]") {
  Random random(11);
  int known = 0, estimated = 0;
  constexpr int kTrials = 4000, kDof = 60, kRepeats = 12;
  for (int trial = 0; trial < kTrials; ++trial) {
    double chi2 = 0, s2 = 0;
    for (int k = 0; k < kDof; ++k) chi2 += std::pow(random.normal(), 2);
    for (int k = 0; k < kRepeats; ++k) s2 += std::pow(random.normal(), 2) / kRepeats;
    known += goodness(chi2, kDof, 0).explained ? 0 : 1;
    estimated += goodness(chi2 / s2, kDof, kRepeats).explained ? 0 : 1;
  }
  INFO(known << " and " << estimated << " of " << kTrials);
  CHECK(known <= 13);  // binomial(4000, 0.001): more than 13 in 0.01 % of runs
  CHECK(estimated <= 13);
}

TEST_CASE("a lucky draw narrows no uncertainty of a known noise, a misfit widens it", "[measure]") {
  CHECK(goodness(50, 100, 0).scale == 1);
  CHECK_THAT(goodness(400, 100, 0).scale, WithinRel(2.0, 1e-12));
  CHECK_FALSE(goodness(400, 100, 0).explained);
  CHECK_THAT(goodness(25, 100, 10).scale, WithinRel(0.5, 1e-12));
  CHECK(goodness(0, 0, 0).scale == 1);
  CHECK(goodness(0, 0, 0).explained);
}
