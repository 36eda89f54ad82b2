#pragma once
// How an emulated tracker in a process of its own learns where the emulated stage stands.

#include <string>
#include <string_view>

#include "app/emulate/robot.hpp"

namespace trammel::emulate {

/// Our own command beside the controller's: no Galil command begins with '@'.
inline constexpr std::string_view kAskStanding = "@STANDING";

/// l, from [mm], epoch, time [s], moving: nine numbers and blanks; the same bits come back.
std::string standing_text(const Standing& standing);

/// Throws DeviceError for what is no standing.
Standing parse_standing(std::string_view text);

/// Asks the emulated stage at `host_port` ("127.0.0.1:5000"), one connection a question. Throws
/// DeviceError when it does not answer within some seconds, UsageError for no HOST:PORT.
Standing ask_standing(const std::string& host_port);

}  // namespace trammel::emulate
