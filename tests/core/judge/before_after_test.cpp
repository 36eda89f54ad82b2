#include "core/judge/before_after.hpp"

#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("errors before and after are distances to the target, phi the shorter way round",
          "[judge]") {
  const std::vector<BeforeAfter> points = {
      {{0, 0, 0}, {3, 4, rad_from_deg(1)}, {0, 0.5, 2 * kPi}},
      {{10, 0, 0}, {10, 1, rad_from_deg(-3)}, {10, 0.1, rad_from_deg(1)}}};
  const Errors position = errors_in(Figure::position_mm, points);
  CHECK(position.before == std::vector<double>{5, 1});
  CHECK(position.summary_before.mean == 3);
  CHECK_THAT(*position.improvement_pct, WithinAbs(90, 1e-9));
  const Errors attitude = errors_in(Figure::attitude_deg, points);
  CHECK_THAT(attitude.summary_before.mean, WithinAbs(2, 1e-12));
  CHECK_THAT(attitude.after[0], WithinAbs(0, 1e-12));
}
