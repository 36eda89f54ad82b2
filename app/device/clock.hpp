#pragma once

#include <memory>

#include "app/device/device.hpp"

namespace trammel::device {

/// What the estimate of a session's length needs.
struct Pace {
  Machine machine;
  double speed_mm_s = 20;
  double acceleration_mm_s2 = 100;
  double settle_s = 0.3;
  double measure_s = 10;
};

/// The computer's monotonic clock: the time that passes, whatever is done to the date meanwhile.
/// end_s is start_s and the nominal moves of the plan at this pace. Proof: clock_test.cpp.
std::unique_ptr<Clock> real_clock(const Pace& pace);

}  // namespace trammel::device
