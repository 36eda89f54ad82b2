#pragma once
// A job as a person and as a program read it.

#include <string>
#include <string_view>

#include "app/job/correction_json.hpp"
#include "store/campaign.hpp"
#include "store/job.hpp"

namespace trammel::job {

/// "paper (SIMULATED)", or the name alone: no figure of a virtual robot is read as a real one's.
std::string campaign_title(const std::string& name, bool simulated);
/// "simulated" or "real".
std::string kind_text(bool simulated);

/// A stored job's parameters in words: "neurons 50, seed 1"; "none" without any.
std::string parameter_words(const std::string& parameters_json);

/// Whether a sentence of a result ("words") asks its reader not to trust the fit as it is. Stored
/// sentences are never changed, so they are known by what they say. Proof: page_test.cpp.
bool is_warning(std::string_view sentence);

/// Whether it says that no reading was held out when the job ran.
bool is_of_no_held_out(std::string_view sentence);

/// {id, key, run, campaign, kind, stage, algorithm_version, parameters, statistics, words, …}
Json job_json(const store::Job& job, const store::CampaignRow& campaign);

/// Head line, sentences, and the table of statistics; in-sample and held-out kept apart.
std::string job_text(const store::Job& job, const store::CampaignRow& campaign);

/// Statistics alone, one line each.
std::string statistics_text(const std::vector<store::Statistic>& statistics);
Json statistics_json(const std::vector<store::Statistic>& statistics);

}  // namespace trammel::job
