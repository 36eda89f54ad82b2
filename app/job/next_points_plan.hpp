#pragma once
// What a diagnosis wants measured next, as a plan.

#include "app/job/correction_json.hpp"
#include "core/plan/plan.hpp"
#include "store/job.hpp"

namespace trammel::job {

/// The name of every such plan; reports leave these points out of before-and-after tables.
inline constexpr const char* kNextPoints = "next-points";

/// The `next_points` of diagnosis_json() as a plan of identify points; no points when it suggests
/// none. Proof: the planned points of a diagnosis are measured and decide it (rounds_test.cpp).
Plan next_points_plan(const Json& diagnosis);

/// The campaign's newest diagnosis. Throws NotFoundError when there is none.
store::Job last_diagnosis(store::Connection& connection, const std::string& campaign);

/// The points that a stored diagnosis suggests. Throws InputError when it is none, NotFoundError
/// when it suggests nothing.
Plan stored_next_points(const store::Job& job);

}  // namespace trammel::job
