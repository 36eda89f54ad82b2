#pragma once

#include <string>

#include "core/measure/reading.hpp"
#include "core/model/robot_model.hpp"

namespace trammel::job {

/// What a model leaves of a stage's readings in x and in y, whose errors can differ by an order:
/// rms of measured - predicted [um], on the readings that were fitted and on those of the set
/// 'validate'; beside it what offsets alone would leave (of the fitted readings' mean, on the
/// machine as stated). Empty where the machine is no point platform that is measured in x and y.
/// Proof: tests/app/job/by_axis_test.cpp.
std::string left_by_axis(const RobotModel& model, const Campaign& campaign);

}  // namespace trammel::job
