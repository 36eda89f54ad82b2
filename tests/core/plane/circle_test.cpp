#include "core/plane/circle.hpp"

#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

std::vector<Place> arc(double x, double y, double radius, double turn, int n) {
  std::vector<Place> points;
  for (int k = 0; k < n; ++k) {
    const double a = turn * k / n;
    points.push_back({x + radius * std::cos(a), y + radius * std::sin(a)});
  }
  return points;
}

double radial_squares(const std::vector<Place>& points, const FittedCircle& c) {
  double sum = 0;
  for (const Place& p : points) {
    const double d = std::hypot(p.x_mm - c.x_mm, p.y_mm - c.y_mm) - c.radius_mm;
    sum += d * d;
  }
  return sum;
}

}  // namespace

TEST_CASE("an exact circle and a short arc of it give the circle back", "[assess]") {
  for (const double turn : {2 * kPi, 0.5 * kPi}) {
    const FittedCircle c = fit_circle(arc(50, -20, 50, turn, 72));
    CHECK_THAT(c.x_mm, WithinAbs(50, 1e-10));
    CHECK_THAT(c.y_mm, WithinAbs(-20, 1e-10));
    CHECK_THAT(c.radius_mm, WithinAbs(50, 1e-10));
    CHECK(c.rms_mm < 1e-11);
  }
}

TEST_CASE("no circle near the fitted one has less radial squares", "[assess]") {
  Random random(11);
  std::vector<Place> points = arc(0, 50, 50, 1.2, 30);
  for (Place& p : points) {
    p.x_mm += 0.5 * random.normal();
    p.y_mm += 0.5 * random.normal();
  }
  const FittedCircle best = fit_circle(points);
  const double least = radial_squares(points, best);
  for (const double step : {1e-4, -1e-4}) {
    CHECK(radial_squares(points, {best.x_mm + step, best.y_mm, best.radius_mm, 0}) > least);
    CHECK(radial_squares(points, {best.x_mm, best.y_mm + step, best.radius_mm, 0}) > least);
    CHECK(radial_squares(points, {best.x_mm, best.y_mm, best.radius_mm + step, 0}) > least);
  }
}

TEST_CASE("two points, one place and a line are no circle", "[assess]") {
  CHECK_THROWS_AS(fit_circle(arc(0, 0, 1, 1, 2)), InputError);
  CHECK_THROWS_AS(fit_circle(std::vector<Place>(5, Place{1, 2})), InputError);
  CHECK_THROWS_AS(fit_circle(std::vector<Place>{{0, 0}, {1, 1}, {2, 2}, {5, 5}}), InputError);
}
