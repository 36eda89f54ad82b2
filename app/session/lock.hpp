#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace trammel::session {

/// One runner per campaign: an OS lock on a file beside the database, which dies with the process.
class CampaignLock {
 public:
  /// Throws Error (exit 1) that names the process which holds it.
  CampaignLock(const std::filesystem::path& database, const std::string& campaign_uuid);
  ~CampaignLock();
  CampaignLock(const CampaignLock&) = delete;
  CampaignLock& operator=(const CampaignLock&) = delete;

  /// Process that runs the campaign now, if any.
  static std::optional<int> holder(const std::filesystem::path& database,
                                   const std::string& campaign_uuid);

 private:
  int descriptor_ = -1;
};

}  // namespace trammel::session
