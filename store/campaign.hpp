#pragma once
// A campaign: one robot under one tracker, all its sessions and readings.

#include <vector>

#include "core/measure/reading.hpp"
#include "store/reading.hpp"
#include "store/session.hpp"

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

/// A walk as it comes from elsewhere: its readings, without the plan it had there.
struct ImportedSession {
  std::string name = "import";
  std::string compensation = {};  // name of a correction whose job is elsewhere; empty: baseline
  std::string plan = {};
  int n_asked = 0;                        // points it was to have; 0: not known
  std::vector<int> held_epochs = {};      // those in which reference points were found again
  std::map<int, std::string> roles = {};  // of readings by seq, as a point's
};

/// What comes with a campaign's readings, by their seq.
struct Exchange {
  std::map<int, std::string> extra_json = {};  // columns of other programs: {"x_…": "text"}
  std::map<int, std::string> raw_reply = {};   // the text a reading was made of
  std::string settings_json = "{}";  // into the sessions: what the readings came from, an object
  std::vector<ImportedSession> sessions = {{}};
  std::map<int, std::size_t> session_of = {};  // place in `sessions`; those left out: the first
  std::vector<std::pair<int, std::string>> exclusions = {};  // seq and reason
};

/// Stores an exchanged campaign with all its readings, in one transaction. The same content under
/// this name is not stored again; without `raw_reply` it is the same whatever raw text is stored,
/// and exclusions do not count.
/// @throws InputError  the name is taken by a campaign with other content; a number out of bounds
///                     (campaign_test.cpp)
ImportResult import_campaign(Connection& connection, const Campaign& campaign,
                             const Exchange& exchange = {});

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
