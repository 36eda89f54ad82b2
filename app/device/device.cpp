#include "app/device/device.hpp"

#include <fmt/format.h>

#include <array>

namespace trammel::device {

const char* name_of(Status status) {
  constexpr std::array<const char*, 7> kNames = {"ok",    "beam broken",     "timeout", "unstable",
                                                 "limit", "following error", "fault"};
  return kNames[static_cast<std::size_t>(status)];
}

std::string watch_text(double watch_host_s) {
  if (watch_host_s > 0) {
    return fmt::format(
        "the controller watches this program: killed, crashed or cut off, it leaves a stage that "
        "the controller stops within {:g} s",
        watch_host_s);
  }
  return "the controller does not watch this program: killed, crashed or cut off, it leaves a "
         "stage "
         "that goes on to the end of its move (\"watch_host_s\" of the stage's \"controller\" "
         "loads a program that stops them)";
}

bool may_retry(Status status) {
  return status == Status::beam_broken || status == Status::timeout || status == Status::unstable;
}

}  // namespace trammel::device
