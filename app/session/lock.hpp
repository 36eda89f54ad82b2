#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace trammel::session {

/// One runner per campaign: an OS lock on a file beside the database, which dies with the process.
/// Whatever the database is called, by a link too, the file is beside the database itself.
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

/// One runner per controller on this machine, whatever its database and whoever its user: a name in
/// the kernel (an abstract socket), which dies with the process.
class ControllerLock {
 public:
  /// `endpoint`: "host:port". Its addresses are locked: "localhost:23" and "127.0.0.1:23" are one.
  /// Throws Error (exit 1) that names the process which holds it. Proof: lock_test.cpp.
  explicit ControllerLock(const std::string& endpoint);
  ~ControllerLock();
  ControllerLock(const ControllerLock&) = delete;
  ControllerLock& operator=(const ControllerLock&) = delete;

 private:
  std::vector<int> sockets_;
};

}  // namespace trammel::session
