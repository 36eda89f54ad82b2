#include "app/device/galil_codes.hpp"

#include <fmt/format.h>

#include <array>

namespace trammel::device {

namespace {

struct StopCode {
  int code;
  Status status;
  const char* text;
};
// Codes as in the error table of ESRF's BLISS [S]; what is done about each is ours.
constexpr std::array<StopCode, 14> kStopCodes = {{
    {0, Status::timeout, "still moves"},
    {1, Status::ok, "stands at its commanded position"},
    {2, Status::limit, "ran into its forward limit switch or soft limit"},
    {3, Status::limit, "ran into its reverse limit switch or soft limit"},
    {4, Status::fault, "was stopped by an ST that did not come from here"},
    {6, Status::fault, "was stopped by the abort input (emergency stop or light curtain)"},
    {7, Status::fault, "was aborted by an AB that did not come from here"},
    {8, Status::following_error, "was switched off: its position error passed the limit"},
    {9, Status::fault, "stopped at an edge that was not searched for"},
    {10, Status::ok, "has found its home"},
    {11, Status::fault, "was stopped by its own abort input"},
    {12, Status::fault, "has an encoder failure"},
    {15, Status::fault, "has an amplifier fault"},
    {99, Status::timeout, "did not come into position in time"},
}};

struct Refusal {
  int code;
  Status status;
};
constexpr std::array<Refusal, 2> kRefusals = {{
    {22, Status::limit},  // begin not possible due to limit switch
    {6, Status::limit},   // number out of range
}};

}  // namespace

StageReport of_stop_code(int code, const std::string& drive) {
  for (const StopCode& known : kStopCodes) {
    if (known.code != code) continue;
    return {known.status, fmt::format("{} {} (SC {})", drive, known.text, code), {}};
  }
  return {Status::fault, fmt::format("{} stopped for an unknown reason (SC {})", drive, code), {}};
}

Status of_refusal(int tc_code) {
  for (const Refusal& known : kRefusals) {
    if (known.code == tc_code) return known.status;
  }
  return Status::fault;
}

}  // namespace trammel::device
