#include "app/emulate/motion.hpp"

#include <cmath>

#include "tests/support/catch.hpp"

namespace trammel::emulate {

namespace {

constexpr Dynamics kDynamics{.speed = 16384, .accel = 256000, .decel = 128000};

/// e' = r' - e / T in small steps, r' from the motion itself.
double integrated_lag(const Motion& motion, double until_s, int steps) {
  const double h = until_s / steps, T = Motion::kServoLag_s;
  double e = 0;
  for (int k = 0; k < steps; ++k) {
    const double v = motion.at((k + 0.5) * h).velocity;
    e += h * (v - (e + 0.5 * h * (v - e / T)) / T);
  }
  return e;
}

}  // namespace

TEST_CASE("a move takes the time of its trapezoid, or of its triangle", "[emulate]") {
  const Motion from = Motion::at_rest(100);
  const double up = 16384.0 / 256000, down = 16384.0 / 128000;
  const double cruise = (81920 - 0.5 * 16384 * (up + down)) / 16384;
  const Motion far = from.to(100 + 81920, kDynamics, 3);
  CHECK_THAT(far.duration_s(), WithinAbs(up + cruise + down, 1e-12));
  CHECK(far.at(far.end_s()).commanded == 100 + 81920);
  CHECK_THAT(far.at(3 + up + cruise / 2).velocity, WithinAbs(16384, 1e-6));

  const Motion near = from.to(100 - 600, kDynamics, 0);  // never reaches its speed
  const double peak = std::sqrt(2 * 600.0 * 256000 * 128000 / (256000 + 128000));
  CHECK(peak < 16384);
  CHECK_THAT(near.duration_s(), WithinAbs(peak / 256000 + peak / 128000, 1e-12));
  CHECK(near.direction() == -1);
  CHECK(from.to(100, kDynamics, 0).duration_s() == 0);
}

TEST_CASE("the motor lags as a first-order servo does", "[emulate]") {
  const Motion motion = Motion::at_rest(0).to(5000, kDynamics, 0);
  for (const double t : {0.02, 0.1, 0.3, motion.end_s() + 0.005}) {
    CAPTURE(t);
    CHECK_THAT(motion.at(t).lag, WithinAbs(integrated_lag(motion, t, 200000), 0.02));
  }
  CHECK(motion.at(0.3).lag > 100);
  CHECK(motion.moving(motion.end_s() + 0.01));
  CHECK_FALSE(motion.moving(motion.end_s() + 0.1));
}

TEST_CASE("how long a move takes does not depend, to the bit, on when it began", "[emulate]") {
  const double early = Motion::at_rest(0).to(12345, kDynamics, 0.1).duration_s();
  const double late = Motion::at_rest(0).to(12345, kDynamics, 98765.4321).duration_s();
  CHECK(early == late);
}

TEST_CASE("a stop decelerates to a whole count, an abort and a cut stand at once", "[emulate]") {
  const Motion motion = Motion::at_rest(0).to(-50000, kDynamics, 0);
  const double t = 1.2345;
  const MotorState then = motion.at(t);
  const Motion stopped = motion.stopped(t, 128000);
  CHECK(stopped.at(t).commanded == then.commanded);
  CHECK(stopped.at(0.5).commanded == motion.at(0.5).commanded);
  const double end = stopped.at(stopped.end_s()).commanded;
  CHECK(end == std::nearbyint(end));
  CHECK_THAT(end, WithinAbs(then.commanded - 16384.0 * 16384 / (2 * 128000), 1));
  CHECK_THAT(stopped.duration_s() - t, WithinAbs(16384.0 / 128000, 1e-3));

  const Motion aborted = motion.aborted(t);
  CHECK(aborted.at(t).commanded == std::nearbyint(then.commanded));
  CHECK_THAT(aborted.at(t).actual(), WithinAbs(then.actual(), 1e-9));
  CHECK_THAT(aborted.at(t + 1).actual(), WithinAbs(aborted.at(t).commanded, 1e-9));

  const Motion cut = motion.cut(t);
  CHECK(cut.at(t + 1).commanded == std::nearbyint(then.actual()));
  CHECK(cut.at(t + 1).lag == 0);
}

TEST_CASE("a motion says when it passes a place, and a jog never ends", "[emulate]") {
  const Motion motion = Motion::at_rest(10).to(20000, kDynamics, 5);
  for (const double place : {11.0, 400.0, 9000.0, 19990.0}) {
    const auto t = motion.reaches(place);
    REQUIRE(t);
    CHECK_THAT(motion.at(5 + *t).commanded, WithinAbs(place, 1e-6));
  }
  CHECK_FALSE(motion.reaches(20001));
  CHECK_FALSE(motion.reaches(9));
  const Motion jog = Motion::at_rest(0).jog(-1000, kDynamics, 0);
  CHECK(std::isinf(jog.end_s()));
  CHECK_THAT(jog.at(100).commanded, WithinAbs(-1000 * 100, 10));
  REQUIRE(jog.reaches(-5000));
  CHECK_THAT(*jog.reaches(-5000), WithinAbs(5, 0.01));
}

TEST_CASE("a blocked motor stays, and its error grows with the command", "[emulate]") {
  const Motion motion = Motion::at_rest(7).to(20000, kDynamics, 0).blocked(0);
  CHECK(motion.at(0.5).actual() == 7);
  CHECK(motion.at(10).lag == 20000 - 7);
  CHECK_FALSE(motion.moving(10));
}

}  // namespace trammel::emulate
