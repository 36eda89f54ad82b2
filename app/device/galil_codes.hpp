#pragma once
// What a stop code (SC) or a refusal (TC) of the controller means for a person and for the runner.

#include <string>

#include "app/device/device.hpp"

namespace trammel::device {

/// Stop code of an axis that has come to rest, e.g. 2: limit, "rail 2 ran into its forward limit
/// switch or soft limit (SC 2)". 1 and 10 are ok. A code that is not in the table is a fault.
StageReport of_stop_code(int code, const std::string& drive);

/// Refusal TC n of a command that should start a move.
Status of_refusal(int tc_code);

}  // namespace trammel::device
