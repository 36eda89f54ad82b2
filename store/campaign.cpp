#include "store/campaign.hpp"

#include <algorithm>
#include <set>

#include "store/clock.hpp"
#include "store/machine.hpp"
#include "store/seal.hpp"
#include "store/session.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

constexpr const char* kImport = "import";  // an epoch's reason, and a session's devices

constexpr const char* kCampaignRows =
    "SELECT campaign_id, uuid, name, kind, origin, created_utc, "
    "(SELECT count(*) FROM session WHERE session.campaign_id = campaign.campaign_id), "
    "(SELECT count(*) FROM reading WHERE reading.campaign_id = campaign.campaign_id), "
    "(SELECT count(*) FROM exclusion WHERE exclusion.campaign_id = campaign.campaign_id) "
    "FROM campaign ";

CampaignRow row_at(const Statement& row) {
  return {.id = row.integer(0),
          .uuid = row.text(1),
          .name = row.text(2),
          .simulated = row.text(3) == "simulated",
          .imported = row.text(4) == "imported",
          .created_utc = row.text(5),
          .n_sessions = static_cast<int>(row.integer(6)),
          .n_readings = static_cast<int>(row.integer(7)),
          .n_exclusions = static_cast<int>(row.integer(8))};
}

void add_facts(Connection& connection, Id campaign_id,
               const std::map<std::string, std::string>& facts) {
  for (const auto& [key, value] : facts) {
    Statement insert(connection, "INSERT INTO campaign_fact VALUES (?,?,?)");
    insert << campaign_id << key << value;
    insert.run();
  }
}

Campaign load_head(Connection& connection, Id campaign_id) {
  Statement row(connection,
                "SELECT name, kind, tracker_sigma_xy_mm, tracker_sigma_phi_rad FROM campaign WHERE "
                "campaign_id = ?");
  row << campaign_id;
  if (!row.step()) throw NotFoundError({.what = "no such campaign"});
  Campaign campaign;
  campaign.name = row.text(0);
  campaign.simulated = row.text(1) == "simulated";
  campaign.machine = load_machine(connection, campaign_id);
  if (!row.is_null(2)) campaign.tracker = TrackerSigma{row.real(2), row.real(3)};
  Statement facts(connection, "SELECT key, value FROM campaign_fact WHERE campaign_id = ?");
  facts << campaign_id;
  while (facts.step()) campaign.facts.emplace(facts.text(0), facts.text(1));
  return campaign;
}

using TextBySeq = std::map<int, std::string>;

const ImportedSession& session_of(const Exchange& exchange, int seq) {
  const auto found = exchange.session_of.find(seq);
  return exchange.sessions[found == exchange.session_of.end() ? 0 : found->second];
}

// Everything an exchange carries, in order.
Sha256 content(const Campaign& c, const Exchange& exchange) {
  Digest digest;
  digest << c.name << static_cast<int>(c.simulated) << c.machine;
  const auto pose = [&](const Pose& p) { digest << p.x_mm << p.y_mm << p.phi_rad; };
  if (c.tracker) digest << c.tracker->xy_mm << c.tracker->phi_rad;
  for (const auto& [key, value] : c.facts) digest << key << value;
  for (const Reading& r : c.readings) {
    const ImportedSession& session = session_of(exchange, r.seq);
    digest << r.seq << session.name << session.compensation << name_of(r.set) << r.conditions.epoch
           << r.conditions.time_s << r.conditions.temp_degc;
    pose(r.target);
    for (const double value : r.conditions.cmd_mm) digest << value;
    for (const double value : r.conditions.from_mm) digest << value;
    if (r.measured) pose(*r.measured);
    const auto extra = exchange.extra_json.find(r.seq);
    if (extra != exchange.extra_json.end()) digest << extra->second;
    const auto raw = exchange.raw_reply.find(r.seq);
    if (raw != exchange.raw_reply.end()) digest << raw->second;
  }
  return digest.finish();
}

Sha256 stored_content(Connection& connection, Id campaign_id, bool with_raw) {
  const LoadedCampaign loaded = load_campaign(connection, campaign_id, {.with_excluded = true});
  Exchange exchange;
  exchange.sessions.clear();
  std::map<Id, std::size_t> places;
  for (const SessionRow& row : list_sessions(connection, campaign_id)) {
    places[row.id] = exchange.sessions.size();
    exchange.sessions.push_back({.name = row.name, .compensation = row.compensation_name});
  }
  for (const StoredReading& stored : readings(connection, campaign_id)) {
    const NewReading& data = stored.data;
    const int seq = data.reading.seq;
    exchange.session_of[seq] = places.at(stored.session_id);
    if (data.extra_json) exchange.extra_json.emplace(seq, *data.extra_json);
    if (with_raw && data.raw_reply) exchange.raw_reply.emplace(seq, *data.raw_reply);
  }
  return content(loaded.campaign, exchange);
}

std::vector<Id> add_sessions(Connection& connection, Id campaign_id, const Campaign& campaign,
                             const Exchange& exchange) {
  std::vector<int> n_readings(exchange.sessions.size());
  std::vector<std::set<int>> epochs(exchange.sessions.size());
  for (const Reading& reading : campaign.readings) {
    const auto place =
        static_cast<std::size_t>(&session_of(exchange, reading.seq) - exchange.sessions.data());
    ++n_readings[place];
    epochs[place].insert(reading.conditions.epoch);
  }
  std::vector<Id> ids;
  for (std::size_t k = 0; k < exchange.sessions.size(); ++k) {
    const ImportedSession& s = exchange.sessions[k];
    const Id id =
        create_session(connection, {.campaign_id = campaign_id,
                                    .name = s.name,
                                    .compensation_name = s.compensation,
                                    .plan_name = s.plan,
                                    .n_imported = n_readings[k],
                                    .n_asked = s.n_asked,
                                    .stage = kImport,
                                    .tracker = kImport,
                                    .settings_json = with_roles(exchange.settings_json, s.roles)});
    for (const int number : epochs[k]) {
      const bool held = std::ranges::count(s.held_epochs, number) > 0;
      add_epoch(connection, id, number, held ? kReferencesHold : kImport);
    }
    ids.push_back(id);
  }
  return ids;
}

// Runs of one session go in together.
void import_readings(Connection& connection, Id campaign_id, const Campaign& campaign,
                     const Exchange& exchange) {
  const std::vector<Id> ids = add_sessions(connection, campaign_id, campaign, exchange);
  const auto id_of = [&](const Reading& reading) {
    return ids[static_cast<std::size_t>(&session_of(exchange, reading.seq) -
                                        exchange.sessions.data())];
  };
  const auto text_of = [](const TextBySeq& texts, int seq) {
    const auto found = texts.find(seq);
    return found == texts.end() ? std::nullopt : std::optional(found->second);
  };
  ReadingWriter writer(connection, campaign_id);
  std::vector<NewReading> batch;
  for (std::size_t k = 0; k < campaign.readings.size(); ++k) {
    const Reading& reading = campaign.readings[k];
    batch.push_back({.reading = reading});
    batch.back().extra_json = text_of(exchange.extra_json, reading.seq);
    batch.back().raw_reply = text_of(exchange.raw_reply, reading.seq);
    const bool run_ends =
        k + 1 == campaign.readings.size() || id_of(campaign.readings[k + 1]) != id_of(reading);
    if (!run_ends && batch.size() < ReadingWriter::kBatch) continue;
    writer.add_all(batch, id_of(reading));
    batch.clear();
  }
  for (const auto& [seq, reason] : exchange.exclusions) {
    exclude_reading(connection, campaign_id, seq, reason);
  }
}

}  // namespace

Id add_campaign(Connection& connection, const Campaign& c, bool imported) {
  validate(c.machine);
  Transaction transaction(connection);
  if (find_campaign(connection, c.name)) {
    throw InputError({.what = "there is a campaign of this name already",
                      .where = {.field = "name"},
                      .got = c.name,
                      .hint = "choose another name"});
  }
  Statement insert(connection,
                   "INSERT INTO campaign (uuid, name, kind, origin, created_utc, "
                   "tracker_sigma_xy_mm, tracker_sigma_phi_rad) VALUES (?,?,?,?,?,?,?)");
  insert << new_uuid() << c.name << (c.simulated ? "simulated" : "real")
         << (imported ? "imported" : "measured") << utc_now();
  insert << (c.tracker ? std::optional(c.tracker->xy_mm) : std::nullopt)
         << (c.tracker && c.machine.measured[2] ? std::optional(c.tracker->phi_rad) : std::nullopt);
  const Id id = insert.run();
  add_machine(connection, id, c.machine);
  add_facts(connection, id, c.facts);
  seal(connection, "campaign", id);
  transaction.commit();
  return id;
}

std::vector<CampaignRow> list_campaigns(Connection& connection) {
  Statement rows(connection, std::string(kCampaignRows) + "ORDER BY campaign_id");
  std::vector<CampaignRow> all;
  while (rows.step()) all.push_back(row_at(rows));
  return all;
}

std::optional<CampaignRow> find_campaign(Connection& connection, std::string_view name) {
  Statement rows(connection, std::string(kCampaignRows) + "WHERE name = ?1 OR uuid = ?1");
  rows << name;
  return rows.step() ? std::optional(row_at(rows)) : std::nullopt;
}

std::optional<CampaignRow> find_campaign(Connection& connection, Id campaign_id) {
  Statement rows(connection, std::string(kCampaignRows) + "WHERE campaign_id = ?1");
  rows << campaign_id;
  return rows.step() ? std::optional(row_at(rows)) : std::nullopt;
}

CampaignRow require_campaign(Connection& connection, std::string_view name) {
  if (auto row = find_campaign(connection, name)) return *std::move(row);
  std::string names;
  for (const CampaignRow& row : list_campaigns(connection)) {
    if (names.size() > 200) {
      names += ", …";
      break;
    }
    names += (names.empty() ? "" : ", ") + row.name;
  }
  throw NotFoundError({.what = "no such campaign",
                       .where = {.file = connection.file().string()},
                       .got = std::string(name),
                       .expected = names.empty() ? "a campaign: there is none yet" : names});
}

Id require_campaign_id(Connection& connection, std::string_view name) {
  Statement row(connection, "SELECT campaign_id FROM campaign WHERE name = ?1 OR uuid = ?1");
  row << name;
  return row.step() ? row.integer(0) : require_campaign(connection, name).id;
}

double campaign_age_s(Connection& connection, Id campaign_id) {
  Statement age(connection,
                "SELECT max(0.0, coalesce((julianday('now') - julianday(created_utc)) * 86400.0, "
                "0.0), coalesce((SELECT max(time_s) FROM reading WHERE reading.campaign_id = "
                "campaign.campaign_id), 0.0)) FROM campaign WHERE campaign_id = ?");
  age << campaign_id;
  const bool there = age.step();
  TRAMMEL_ASSERT(there);
  return age.real(0);
}

ImportResult import_campaign(Connection& connection, const Campaign& campaign,
                             const Exchange& exchange) {
  Transaction transaction(connection);
  if (const auto there = find_campaign(connection, campaign.name)) {
    if (stored_content(connection, there->id, !exchange.raw_reply.empty()) ==
        content(campaign, exchange)) {
      return {.campaign_id = there->id, .already_stored = true};
    }
  }
  const Id id = add_campaign(connection, campaign, true);
  import_readings(connection, id, campaign, exchange);
  transaction.commit();
  return {.campaign_id = id, .already_stored = false};
}

LoadedCampaign load_campaign(Connection& connection, Id campaign_id, const LoadOptions& options) {
  LoadedCampaign loaded{
      .campaign = load_head(connection, campaign_id), .exclusions = {}, .sessions = {}};
  std::map<int, Exclusion> excluded;
  for (Exclusion& e : exclusions(connection, campaign_id)) excluded.emplace(e.seq, std::move(e));
  const std::vector<SessionReading> all =
      session_readings(connection, campaign_id, options.sessions);
  std::set<Id> sessions;
  loaded.campaign.readings.reserve(all.size());
  for (const auto& [session_id, reading] : all) {
    sessions.insert(session_id);
    const auto found = excluded.find(reading.seq);
    if (found != excluded.end()) loaded.exclusions.push_back(found->second);
    if (found == excluded.end() || options.with_excluded) {
      loaded.campaign.readings.push_back(reading);
    }
  }
  loaded.sessions.assign(sessions.begin(), sessions.end());
  return loaded;
}

}  // namespace trammel::store
