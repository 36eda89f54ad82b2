#include "app/device/device.hpp"

#include <array>

namespace trammel::device {

const char* name_of(Status status) {
  constexpr std::array<const char*, 7> kNames = {"ok",    "beam broken",     "timeout", "unstable",
                                                 "limit", "following error", "fault"};
  return kNames[static_cast<std::size_t>(status)];
}

bool may_retry(Status status) {
  return status == Status::beam_broken || status == Status::timeout || status == Status::unstable;
}

}  // namespace trammel::device
