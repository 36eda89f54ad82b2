#include "app/device/clock.hpp"

#include <cmath>

#include "app/device/galil_axis.hpp"
#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::device;

TEST_CASE("a real session's end is its start and the way of all its moves", "[device][clock]") {
  const Pace pace{.machine = machine_of(paper_mechanism()), .settle_s = 0.5, .measure_s = 9};
  Plan plan;
  plan.approach_mm = 5;
  plan.points.push_back({.seq = 1, .target = {10, 0, 0}});
  plan.points.push_back({.seq = 2, .target = {10, 0, 0}, .approach = {1, 1, 1}});
  const Displacements home = drives_of(pace.machine, {0, 0, 0});
  const Displacements target = drives_of(pace.machine, {10, 0, 0});
  const double way_s = travel_time_s((target - home).cwiseAbs().maxCoeff(), 20, 100) + 0.5;
  const double approach_s = travel_time_s(5, 20, 100) + 0.5;  // back, and forth
  const auto clock = real_clock(pace);
  clock->start(plan, 1000);
  CHECK(clock->end_s() == Approx(1000 + way_s + 9 + 2 * approach_s + 9));
  const double now_s = clock->time_s(plan.points[0]);
  CHECK(now_s >= 1000);
  CHECK(now_s < 1060);
  CHECK(clock->time_s(plan.points[1]) >= now_s);
}

TEST_CASE("a target out of reach has no time", "[device][clock]") {
  Plan plan;
  plan.points.push_back({.seq = 1, .target = {5000, 0, 0}});
  CHECK_THROWS_AS(real_clock({.machine = machine_of(paper_mechanism())})->start(plan, 0),
                  InputError);
}
