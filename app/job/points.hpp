#pragma once
// The points of a job's result: member "points" of the stored document, columns by name.

#include "app/job/json.hpp"
#include "store/job.hpp"

namespace trammel::job {

/// Its canonical text.
std::string points_text(const std::vector<store::JobPoint>& points);

/// Of a stored job, in the order of seq, whichever version of the schema it was stored under.
std::vector<store::JobPoint> points_of(store::Connection& connection, const store::Job& job);

}  // namespace trammel::job
