#pragma once
// What lies beyond the readings that a job fitted: there its correction extrapolates.

#include <span>
#include <string>
#include <vector>

#include "core/judge/range.hpp"
#include "store/job.hpp"

namespace trammel::job {

/// Of what a job fitted. Proof: assess_test.cpp, session_test.cpp.
FittedRange fitted_range(store::Connection& connection, const store::Job& job);

/// "3 of 80 `points` lie outside …", one sentence for place and one for orientation; none when all
/// lie within.
std::vector<std::string> extrapolation_words(const FittedRange& range,
                                             std::span<const Pose> targets,
                                             const std::string& point, const std::string& of = "");

}  // namespace trammel::job
