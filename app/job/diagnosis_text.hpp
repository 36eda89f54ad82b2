#pragma once

#include <string>

#include "app/job/correction_json.hpp"

namespace trammel::job {

/// A diagnosis as an argument a person can follow, from diagnosis_json(): what was expected, what
/// is seen and where, what was named and why not its rivals, how far the gap shrank on unseen
/// readings, what could not have been seen, what to measure next.
std::string diagnosis_text(const Json& diagnosis);

}  // namespace trammel::job
