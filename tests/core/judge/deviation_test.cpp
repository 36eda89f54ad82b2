#include "core/judge/deviation.hpp"

#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("position and attitude errors are distances, attitude the shorter way round",
          "[assess]") {
  const Pose measured{3, 4, kPi - 0.01}, wanted{0, 0, -kPi + 0.01};
  CHECK_THAT(position_error_mm(measured, wanted), WithinAbs(5, 1e-14));
  CHECK_THAT(attitude_error_rad(measured, wanted), WithinAbs(0.02, 1e-12));
}

TEST_CASE("the paper's R^2 is blind to bias and scale, 1 - SSE/SST is not", "[assess]") {
  const std::vector<double> measured = {1, 2, 3, 4};
  const std::vector<double> predicted = {12, 14, 16, 18};  // 10 + 2 m
  const FitScores s = fit_scores(predicted, measured);
  CHECK_THAT(*s.r2_pearson, WithinAbs(1.0, 1e-14));
  CHECK(*s.r2 < -100);
  CHECK_THAT(s.mae, WithinAbs(12.5, 1e-12));
  CHECK_THAT(s.mse, WithinAbs((121 + 144 + 169 + 196) / 4.0, 1e-12));
}

TEST_CASE("a constant column has no R^2 instead of a NaN", "[assess]") {
  const std::vector<double> constant = {0.3, 0.3, 0.3}, varied = {0.1, 0.2, 0.3};
  CHECK_FALSE(fit_scores(varied, constant).r2.has_value());
  CHECK_FALSE(fit_scores(varied, constant).r2_pearson.has_value());
  CHECK_FALSE(fit_scores(constant, varied).r2_pearson.has_value());
  CHECK(fit_scores(constant, varied).r2.has_value());
}

TEST_CASE("predictions that do not pair with measurements are refused", "[assess]") {
  const std::vector<double> one = {1}, two = {1, 2};
  CHECK_THROWS_AS(fit_scores(one, two), InputError);
  CHECK_THROWS_AS(fit_scores({}, {}), InputError);
}
