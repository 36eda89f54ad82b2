#pragma once
// Databases on disk in a folder that goes away, and small campaigns to put into them.

#include <filesystem>

#include "store/campaign.hpp"
#include "store/open.hpp"
#include "store/session.hpp"

namespace trammel::test {

/// A folder of its own under the system's temporary folder, removed at the end.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return path_ / name; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// n readings of the paper's robot along the x axis, the last of them for validation; temperatures
/// and times in every second one.
Campaign small_campaign(int n = 6, const std::string& name = "rail-test");

/// A session's plan: n points along x.
std::vector<store::Point> line_plan(int n);

/// A reading at `point`, 5 um off target.
store::NewReading reading_at(const store::Point& point);

/// The n readings of a session under a fresh set-up, all stored.
store::Id measured_session(store::Connection& db, store::Id campaign_id, const std::string& name,
                           int n);

/// The single number of a query, through any connection.
std::int64_t number(store::Connection& db, std::string_view sql);

}  // namespace trammel::test
