#pragma once
// A reading that the database would not take is not lost: it goes to a file beside it.

#include <filesystem>
#include <string>
#include <vector>

#include "store/campaign.hpp"
#include "store/session.hpp"

namespace trammel::session {

struct UnsavedReading {
  std::string campaign_uuid;
  std::string session;
  int point_seq = 0;
  int epoch = 0;  // its number
  store::NewReading reading;
};

/// "<database>.<campaign's uuid>.unsaved.jsonl"
std::filesystem::path side_file(const std::filesystem::path& database,
                                const std::string& campaign_uuid);

/// Adds one line, {"schema": "trammel/unsaved-reading/1", …, "sha256"}: on the disk when this has
/// returned. Numbers read back bit for bit. Throws StoreError when it can't be written either.
void keep_aside(const std::filesystem::path& file, const UnsavedReading& reading);

/// Room for the side file while a session runs: a disk that is full when a reading must be kept
/// aside was not when the session began. A file that nothing was added to goes with it.
class SideRoom {
 public:
  /// Throws StoreError where there is no room now: then nothing should begin to move.
  explicit SideRoom(const std::filesystem::path& side_file);
  ~SideRoom();
  SideRoom(const SideRoom&) = delete;
  SideRoom& operator=(const SideRoom&) = delete;

 private:
  std::filesystem::path file_;
};

struct Recovery {
  int n_lines = 0;
  int n_taken = 0;  // are in the database now, read back and compared
  int n_there = 0;  // were there already: the write had been done after all, or this ran before
  std::vector<std::string> problems = {};  // lines that could not be taken, and why; the file stays
};

/// Takes the campaign's side file into the database, each reading once, in the attempt that was
/// open for it; compares what is stored with the file, then removes the file. A line that was cut
/// off while it was written was never acknowledged and is left out. The caller holds the campaign's
/// lock. `dry`: only says what would be done.
/// Proof: side_file_test.cpp (a disk that fails at each operation, and one that is full).
Recovery recover(store::Connection& connection, const store::CampaignRow& campaign,
                 bool dry = false);

}  // namespace trammel::session
