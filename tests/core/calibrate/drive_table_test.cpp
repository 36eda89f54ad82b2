#include "core/calibrate/drive_table.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// Positions spread over 103 to 397 mm, seeded.
template <class F>
std::vector<DriveSample> sampled(const F& correction) {
  Random random(5);
  std::vector<DriveSample> samples;
  for (int k = 0; k < 2000; ++k) {
    const double l_mm = random.uniform(103, 397);
    samples.push_back({l_mm, correction(l_mm)});
  }
  return samples;
}

}  // namespace

TEST_CASE("what is straight between the knots is carried whole, beyond the ends it stays",
          "[calibrate]") {
  const auto bent = [](double l_mm) { return std::abs(l_mm - 200) * 1e-3 - 0.05; };
  const auto samples = sampled(bent);
  const DriveTable table = fit_drive_table(samples, 10, 256);
  CHECK(table.first_mm == 100);
  CHECK(table.values_mm.size() == 31);
  CHECK(error_left(samples, table).max_mm < 1e-6);
  CHECK(table.at(-1000) == table.values_mm.front());
  CHECK(table.at(1000) == table.values_mm.back());
  CHECK(table.knot_mm(30) == 400);
}

TEST_CASE("a wave of the screw is left by its curvature between the knots", "[calibrate]") {
  // a sin(2 pi l / P): straight pieces of length h leave at most a (pi h / P)^2 / 2 where they meet
  // the curve at the knots; the best pieces leave less.
  constexpr double kAmplitudeMm = 0.01, kPeriodMm = 50, kStepMm = 5;
  const double pi = std::acos(-1.0);
  const auto samples =
      sampled([&](double l_mm) { return kAmplitudeMm * std::sin(2 * pi * l_mm / kPeriodMm); });
  const double bound = kAmplitudeMm * std::pow(pi * kStepMm / kPeriodMm, 2) / 2;
  const TableError left = error_left(samples, fit_drive_table(samples, kStepMm, 256));
  CHECK(left.max_mm < bound);
  CHECK(left.max_mm > bound / 4);
  CHECK(left.rms_mm < left.max_mm);
  const TableError finer = error_left(samples, fit_drive_table(samples, kStepMm / 2, 256));
  CHECK(finer.max_mm < left.max_mm / 3);
}

TEST_CASE("knots without samples lie straight between others", "[calibrate]") {
  std::vector<DriveSample> samples;
  for (double l_mm = 0; l_mm <= 30; l_mm += 1) samples.push_back({l_mm, 0.01});
  for (double l_mm = 80; l_mm <= 110; l_mm += 1) samples.push_back({l_mm, 0.06});
  const DriveTable table = fit_drive_table(samples, 10, 256);
  for (double l_mm = 30; l_mm <= 80; l_mm += 10) CHECK(table.at(l_mm) >= 0.0099);
  CHECK_THAT(table.at(55), WithinAbs(0.035, 0.002));
}

TEST_CASE("a table that no controller holds is refused", "[calibrate]") {
  const auto samples = sampled([](double) { return 0.0; });
  CHECK_THROWS_AS(fit_drive_table(samples, 1, 256), InputError);  // 295 knots
  CHECK_THROWS_AS(fit_drive_table(samples, 0, 256), InputError);
  CHECK_THROWS_AS(fit_drive_table({}, 1, 256), InputError);
}
