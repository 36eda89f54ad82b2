#include "app/device/galil_axis.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

using Counts = std::vector<std::int64_t>;

/// The paper's stage: 10 mm of lead, 8192 counts a turn.
const GalilAxes kAxes = {
    {{'A', 10, 8192, 1, 1, 0}, {'B', 10, 8192, 1, -1, 250}, {'C', 5, 4096, 2, 1, -3}}};

double time_of(const GalilAxisMove& axis) {
  return travel_time_s(std::abs(static_cast<double>(axis.distance_counts)),
                       static_cast<double>(axis.speed), static_cast<double>(axis.acceleration));
}

}  // namespace

TEST_CASE("a count is 1.2207 um on the paper's screws, and half a turn is 4096",
          "[device][galil]") {
  CHECK(1000 / kAxes[0].counts_per_mm() == Approx(1.2207).margin(5e-5));
  CHECK(counts_of(kAxes[0], 5.0) == 4096);
  CHECK(counts_of(kAxes[1], 250.0) == 0);
  CHECK(counts_of(kAxes[1], 260.0) == -8192);  // its counts fall
  CHECK(counts_of(kAxes[2], 2.0) == 8192);     // two turns of the motor for one of the screw
}

TEST_CASE("from millimetres to counts and back is off by half a count at most", "[device][galil]") {
  std::mt19937_64 random(1);
  for (const GalilAxis& axis : kAxes) {
    for (int k = 0; k < 1000; ++k) {
      const double l_mm = static_cast<double>(random() % 600'000) / 1000;
      const auto counts = counts_of(axis, l_mm);
      REQUIRE(counts);
      CHECK(std::abs(axis.mm(static_cast<double>(*counts)) - l_mm) <=
            0.5000001 / axis.counts_per_mm());
    }
  }
}

TEST_CASE("what the controller cannot do is refused, not cut to size", "[device][galil]") {
  const GalilAxis& axis = kAxes[0];
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double range_mm = static_cast<double>(kGalilMaxCounts) / axis.counts_per_mm();
  CHECK(counts_of(axis, range_mm) == kGalilMaxCounts);
  CHECK_FALSE(counts_of(axis, range_mm + 0.001));
  CHECK_FALSE(counts_of(axis, -range_mm - 0.001));
  CHECK_FALSE(counts_of(axis, nan));
  CHECK(speed_counts(axis, 13.02) == 10666);  // even: 10665.98
  CHECK_FALSE(speed_counts(axis, 1e-4));
  CHECK_FALSE(speed_counts(axis, 0));
  CHECK_FALSE(speed_counts(axis, 20'000));
  CHECK_FALSE(speed_counts(axis, nan));
  CHECK(acceleration_counts(axis, 100) == 81'920);
  CHECK(acceleration_counts(axis, 100.1) == 82'944);
  CHECK_FALSE(acceleration_counts(axis, 2e6));
  CHECK_FALSE(acceleration_counts(axis, nan));
}

TEST_CASE("axes that start together end together, whatever their ways", "[device][galil]") {
  std::mt19937_64 random(2);
  const auto draw = [&](std::int64_t most) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * most)) - most;
  };
  for (int k = 0; k < 2000; ++k) {
    const std::int64_t most = k % 2 == 0 ? 400'000 : 300;
    const Counts from = {draw(most), draw(most), draw(most)};
    const Counts to = {draw(most), k % 7 == 0 ? from[1] : draw(most), draw(most)};
    const GalilMove move = plan_galil_move(kAxes, from, to, 20, 100);
    for (std::size_t i = 0; i < kAxes.size(); ++i) {
      const GalilAxisMove& axis = move.axes[i];
      CHECK(axis.to_counts == to[i]);
      CHECK(axis.distance_counts == to[i] - from[i]);
      if (axis.distance_counts == 0) {
        CHECK(axis.speed == 0);
        continue;
      }
      CAPTURE(k, i, axis.distance_counts, axis.speed, axis.acceleration, move.time_s);
      CHECK(axis.speed % kGalilSpeedStep == 0);
      CHECK(axis.acceleration % kGalilAccelerationStep == 0);
      CHECK(axis.speed >= kGalilSpeedStep);
      const double step_share = 2.0 / static_cast<double>(axis.speed);
      CHECK(time_of(axis) <= move.time_s * (1 + 1e-12));
      CHECK(time_of(axis) >= move.time_s * (1 - 1e-12 - step_share));
      CHECK(static_cast<double>(axis.speed) / kAxes[i].counts_per_mm() <=
            20 * (1 + 2 * step_share));
    }
  }
}

TEST_CASE("a move to where the rails stand starts nothing", "[device][galil]") {
  const Counts at = {1, 2, 3};
  const GalilMove move = plan_galil_move(kAxes, at, at, 20, 100);
  CHECK(move.time_s == 0);
  for (const GalilAxisMove& axis : move.axes) CHECK(axis.distance_counts == 0);
}
