#pragma once
// A job as a person and as a program read it.

#include <string>

#include "app/job/correction_json.hpp"
#include "store/job.hpp"

namespace trammel::job {

/// {id, key, run, stage, algorithm_version, parameters, statistics, words, details, …}
Json job_json(const store::Job& job, const std::string& campaign);

/// Head line, sentences, and the table of statistics; in-sample and held-out kept apart.
std::string job_text(const store::Job& job, const std::string& campaign);

/// Statistics alone, one line each.
std::string statistics_text(const std::vector<store::Statistic>& statistics);
Json statistics_json(const std::vector<store::Statistic>& statistics);

}  // namespace trammel::job
