#pragma once
// The contest's table as a person reads it.

#include <string>

#include "app/job/correction_json.hpp"

namespace trammel::job {

/// One line a method: held-out mean, 95 %, max, U (k = 2), time taken, and what is left depends on.
/// `details` and `timing` of a stored contest; empty for another stage's.
std::string contest_table(const Json& details, const Json& timing);

}  // namespace trammel::job
