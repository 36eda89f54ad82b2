#pragma once
// What the screen found, as JSON and as text: one wording for every door.

#include <string>
#include <vector>

#include "app/job/json.hpp"
#include "core/measure/screen.hpp"

namespace trammel::job {

/// [{"kind", "gravity", "what", "why", "seqs": "all" or […], "advice"}]
Json findings_json(const std::vector<Suspicion>& found);

/// A line for each finding: "doubt   stale: repeats … (seq 41): …". Proof:
/// tests/core/measure/screen_test.cpp.
std::string findings_text(const std::vector<Suspicion>& found);

}  // namespace trammel::job
