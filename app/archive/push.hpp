#pragma once
// A station's rows, sent to the archive: what it has not, a campaign at a time.

#include <functional>
#include <string>
#include <vector>

#include "app/archive/link.hpp"
#include "store/canonical.hpp"

namespace trammel::archive {

/// Where a campaign ends: of its readings' chain, and of its other rows (SHA-256 over their seals
/// in the order of their bytes). Digests as 64 hexadecimal digits.
struct Head {
  std::string head = {};
  std::int64_t last_seq = 0;
  std::int64_t n_readings = 0;
  std::string rows_sha256 = {};
  std::int64_t n_rows = 0;
  bool operator==(const Head&) const = default;
};

struct CampaignName {
  store::Id id = 0;
  std::string uuid, name;
};
std::vector<CampaignName> campaigns_of(store::Connection& db);

/// Of the campaign in the file, as it stands.
Head local_head(store::Connection& db, const CampaignName& campaign);

struct Pushed {
  std::string campaign, uuid;
  std::int64_t n_rows = 0;      // sent now
  std::int64_t n_readings = 0;  // sent now
  Head head = {};               // as the archive acknowledged it
};

/// Sends each campaign's new rows in a transaction of its own: rows, then readings, by COPY. The
/// archive recomputes every digest and the chain before it moves its head; the campaign is pushed
/// when it has answered with the head that the file has, and committed. What was pushed before is
/// not sent again, and a push that was cut is simply run again.
///
/// @throws InputError  the archive has the campaign from another station, or with another chain or
///                     other rows than the file: both heads are named, nothing is merged
/// @throws StoreError  a row is not what was stored (db verify); the archive refused
/// @throws DeviceError the connection is gone
/// Proof: push_pull_test.cpp
std::vector<Pushed> push(Link& link, store::Connection& db, const std::string& station,
                         const std::vector<CampaignName>& campaigns,
                         const std::function<void(int done, const Pushed&)>& progress);

}  // namespace trammel::archive
