#pragma once
// Databases of stations with a row of every kind, and what they hold, to compare.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/archive/push.hpp"
#include "app/archive/work.hpp"
#include "store/connection.hpp"

namespace trammel::tests {

/// A campaign with walks (open, failed and interrupted attempts among them), exclusions, jobs with
/// parents, statistics and forced runs, models, and numbers at the ends of doubles.
void add_full_campaign(store::Connection& db, const std::string& name);

/// `n` campaigns named "PREFIX k" that differ, of 20 readings each, which every stage can fit.
void add_small_campaigns(store::Connection& db, const std::string& prefix, int n);

/// Every table's rows, as canonical bytes in the order of their numbers, without the open attempts.
std::map<std::string, std::vector<std::string>> content(const std::filesystem::path& file);

/// Pushes all of `file` by the archive at `uri`.
std::vector<archive::Pushed> push_all(const std::string& uri, const std::filesystem::path& file,
                                      const std::string& station);

/// The single text of a query at the archive.
std::string asked(const std::string& uri, const std::string& sql);

/// The question that queues this stage for the campaigns of which `where` is true.
inline std::string queue_of(const std::string& stage, const std::string& where = "true",
                            bool force = false, const std::string& parameters = "NULL") {
  return "SELECT trammel.queue('" + stage + "', " + parameters + ", " + (force ? "true" : "false") +
         ", ARRAY(SELECT campaign FROM trammel.campaign JOIN trammel.campaign_head USING "
         "(campaign) "
         "WHERE " +
         where + " ORDER BY moved_at DESC))";
}

/// A worker at that archive, until nothing is queued.
archive::WorkDone work_at(const std::string& uri, const std::string& station, unsigned jobs = 1,
                          double lease_s = 60);

inline const std::string kWorker = "eeeeeeee-eeee-4eee-8eee-eeeeeeeeeeee";
inline const std::string kStationA = "aaaaaaaa-aaaa-4aaa-8aaa-aaaaaaaaaaaa";
inline const std::string kStationB = "bbbbbbbb-bbbb-4bbb-8bbb-bbbbbbbbbbbb";

}  // namespace trammel::tests
