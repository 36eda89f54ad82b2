#pragma once
// A campaign: one robot under one tracker, all its sessions and readings.

#include <vector>

#include "core/measure/reading.hpp"
#include "store/reading.hpp"

namespace trammel::store {

struct CampaignRow {
  Id id = 0;
  std::string uuid;
  std::string name;
  bool simulated = false;
  bool imported = false;
  std::string created_utc;
  int n_sessions = 0;
  int n_readings = 0;
  int n_exclusions = 0;
};

/// Stores a new campaign; its readings are not looked at.
/// @throws InputError  the name is taken; a number out of bounds
Id add_campaign(Connection& connection, const Campaign& campaign, bool imported = false);

std::vector<CampaignRow> list_campaigns(Connection& connection);

/// By name or uuid.
std::optional<CampaignRow> find_campaign(Connection& connection, std::string_view name);
std::optional<CampaignRow> find_campaign(Connection& connection, Id campaign_id);
/// @throws NotFoundError naming the campaigns there are
CampaignRow require_campaign(Connection& connection, std::string_view name);
/// Its id, without what a row has to count.
Id require_campaign_id(Connection& connection, std::string_view name);

/// Seconds since the campaign was made, by the computer's date; not below 0, nor before its last
/// reading: a date that was put back sends no reading back.
double campaign_age_s(Connection& connection, Id campaign_id);

struct ImportResult {
  Id campaign_id = 0;
  bool already_stored = false;  // the same content is there under this name: nothing was written
};

/// Stores an exchanged campaign with all its readings as one session "import", in one transaction.
/// `extra_json` keeps the reading's columns of other programs ({"x_…": "text"}) by seq, `raw_reply`
/// the text it was made of; `settings_json` goes into the session: what the readings came from.
/// Without `raw_reply` the same readings count as the same content whatever raw text is stored.
/// @throws InputError  the name is taken by a campaign with other content; a number out of bounds
///                     (campaign_test.cpp)
ImportResult import_campaign(Connection& connection, const Campaign& campaign,
                             const std::map<int, std::string>& extra_json = {},
                             const std::string& settings_json = "{}",
                             const std::map<int, std::string>& raw_reply = {});

struct LoadOptions {
  std::vector<Id> sessions = {};  // empty: all
  bool with_excluded = false;     // an export keeps them
};

struct LoadedCampaign {
  Campaign campaign;                  // readings by seq, less the excluded ones
  std::vector<Exclusion> exclusions;  // of the sessions looked at: honoured unless with_excluded
  std::vector<Id> sessions;           // whose readings these are
};

/// @throws NotFoundError  no such campaign
LoadedCampaign load_campaign(Connection& connection, Id campaign_id,
                             const LoadOptions& options = {});

}  // namespace trammel::store
