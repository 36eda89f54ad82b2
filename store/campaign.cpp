#include "store/campaign.hpp"

#include <algorithm>
#include <set>

#include "store/clock.hpp"
#include "store/seal.hpp"
#include "store/session.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

constexpr const char* kImport = "import";

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

void add_chains(Connection& connection, Id campaign_id, const Geometry& geometry) {
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    Statement insert(connection, "INSERT INTO campaign_chain VALUES (?,?,?,?,?,?,?,?,?)");
    insert << campaign_id << i + 1 << c.alpha_rad << c.beta_rad << c.r_mm << c.S_mm << c.l_zero_mm
           << c.R_mm << c.h_mm;
    insert.run();
  }
}

void add_facts(Connection& connection, Id campaign_id,
               const std::map<std::string, std::string>& facts) {
  for (const auto& [key, value] : facts) {
    Statement insert(connection, "INSERT INTO campaign_fact VALUES (?,?,?)");
    insert << campaign_id << key << value;
    insert.run();
  }
}

Geometry load_geometry(Connection& connection, Id campaign_id) {
  Geometry geometry;
  Statement rows(connection,
                 "SELECT alpha_rad, beta_rad, platform_r_mm, link_S_mm, l_zero_mm, rail_R_mm, h_mm "
                 "FROM campaign_chain WHERE campaign_id = ? ORDER BY chain");
  rows << campaign_id;
  for (Chain& chain : geometry.chains) {
    if (!rows.step()) throw StoreError({.what = "the campaign's mechanism is not complete"});
    chain = {rows.real(0), rows.real(1), rows.real(2), rows.real(3),
             rows.real(4), rows.real(5), rows.real(6)};
  }
  return geometry;
}

Campaign load_head(Connection& connection, Id campaign_id) {
  Statement row(connection,
                "SELECT name, kind, screw_lead_mm, home_x_mm, home_y_mm, home_phi_rad, l_min_mm, "
                "l_max_mm, tracker_sigma_xy_mm, tracker_sigma_phi_rad FROM campaign WHERE "
                "campaign_id = ?");
  row << campaign_id;
  if (!row.step()) throw NotFoundError({.what = "no such campaign"});
  Campaign campaign;
  campaign.name = row.text(0);
  campaign.simulated = row.text(1) == "simulated";
  campaign.mechanism = {.geometry = load_geometry(connection, campaign_id),
                        .screw_lead_mm = row.real(2),
                        .home = {row.real(3), row.real(4), row.real(5)},
                        .limits = {row.real(6), row.real(7)}};
  if (!row.is_null(8)) campaign.tracker = TrackerSigma{row.real(8), row.real(9)};
  Statement facts(connection, "SELECT key, value FROM campaign_fact WHERE campaign_id = ?");
  facts << campaign_id;
  while (facts.step()) campaign.facts.emplace(facts.text(0), facts.text(1));
  return campaign;
}

using TextBySeq = std::map<int, std::string>;

// Everything an exchange carries, in order.
Sha256 content(const Campaign& c, const TextBySeq& extra_json, const TextBySeq& raw_reply) {
  Digest digest;
  digest << c.name << static_cast<int>(c.simulated) << c.mechanism.screw_lead_mm;
  const auto pose = [&](const Pose& p) { digest << p.x_mm << p.y_mm << p.phi_rad; };
  const GeometryVector geometry = to_vector(c.mechanism.geometry);
  for (const double value : geometry) digest << value;
  pose(c.mechanism.home);
  digest << c.mechanism.limits.l_min_mm << c.mechanism.limits.l_max_mm;
  if (c.tracker) digest << c.tracker->xy_mm << c.tracker->phi_rad;
  for (const auto& [key, value] : c.facts) digest << key << value;
  for (const Reading& r : c.readings) {
    digest << r.seq << name_of(r.set) << r.conditions.epoch << r.conditions.time_s
           << r.conditions.temp_degc;
    pose(r.target);
    for (const double value : r.conditions.cmd_mm) digest << value;
    for (const double value : r.conditions.from_mm) digest << value;
    if (r.measured) pose(*r.measured);
    const auto extra = extra_json.find(r.seq);
    if (extra != extra_json.end()) digest << extra->second;
    const auto raw = raw_reply.find(r.seq);
    if (raw != raw_reply.end()) digest << raw->second;
  }
  return digest.finish();
}

Sha256 stored_content(Connection& connection, Id campaign_id, bool with_raw) {
  const LoadedCampaign loaded = load_campaign(connection, campaign_id, {.with_excluded = true});
  TextBySeq extra_json, raw_reply;
  for (const StoredReading& stored : readings(connection, campaign_id)) {
    const NewReading& data = stored.data;
    if (data.extra_json) extra_json.emplace(data.reading.seq, *data.extra_json);
    if (with_raw && data.raw_reply) raw_reply.emplace(data.reading.seq, *data.raw_reply);
  }
  return content(loaded.campaign, extra_json, raw_reply);
}

void import_readings(Connection& connection, Id campaign_id, const Campaign& campaign,
                     const TextBySeq& extra_json, const std::string& settings_json,
                     const TextBySeq& raw_reply) {
  const Id session =
      create_session(connection, {.campaign_id = campaign_id,
                                  .name = kImport,
                                  .n_imported = static_cast<int>(campaign.readings.size()),
                                  .stage = kImport,
                                  .tracker = kImport,
                                  .settings_json = settings_json});
  std::set<int> epochs;
  for (const Reading& reading : campaign.readings) epochs.insert(reading.conditions.epoch);
  for (const int number : epochs) add_epoch(connection, session, number, kImport);
  ReadingWriter writer(connection, campaign_id);
  std::vector<NewReading> batch;
  for (const Reading& reading : campaign.readings) {
    batch.push_back({.reading = reading});
    const auto extra = extra_json.find(reading.seq);
    if (extra != extra_json.end()) batch.back().extra_json = extra->second;
    const auto raw = raw_reply.find(reading.seq);
    if (raw != raw_reply.end()) batch.back().raw_reply = raw->second;
    if (batch.size() < ReadingWriter::kBatch) continue;
    writer.add_all(batch, session);
    batch.clear();
  }
  writer.add_all(batch, session);
}

}  // namespace

Id add_campaign(Connection& connection, const Campaign& c, bool imported) {
  validate(c.mechanism);
  Transaction transaction(connection);
  if (find_campaign(connection, c.name)) {
    throw InputError({.what = "there is a campaign of this name already",
                      .where = {.field = "name"},
                      .got = c.name,
                      .hint = "choose another name"});
  }
  const Mechanism& m = c.mechanism;
  Statement insert(connection,
                   "INSERT INTO campaign (uuid, name, kind, origin, created_utc, screw_lead_mm, "
                   "home_x_mm, home_y_mm, home_phi_rad, l_min_mm, l_max_mm, tracker_sigma_xy_mm, "
                   "tracker_sigma_phi_rad) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)");
  insert << new_uuid() << c.name << (c.simulated ? "simulated" : "real")
         << (imported ? "imported" : "measured") << utc_now() << m.screw_lead_mm << m.home.x_mm
         << m.home.y_mm << m.home.phi_rad << m.limits.l_min_mm << m.limits.l_max_mm;
  insert << (c.tracker ? std::optional(c.tracker->xy_mm) : std::nullopt)
         << (c.tracker ? std::optional(c.tracker->phi_rad) : std::nullopt);
  const Id id = insert.run();
  add_chains(connection, id, m.geometry);
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
                             const std::map<int, std::string>& extra_json,
                             const std::string& settings_json,
                             const std::map<int, std::string>& raw_reply) {
  Transaction transaction(connection);
  if (const auto there = find_campaign(connection, campaign.name)) {
    if (stored_content(connection, there->id, !raw_reply.empty()) ==
        content(campaign, extra_json, raw_reply)) {
      return {.campaign_id = there->id, .already_stored = true};
    }
  }
  const Id id = add_campaign(connection, campaign, true);
  import_readings(connection, id, campaign, extra_json, settings_json, raw_reply);
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
