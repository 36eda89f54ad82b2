#include "app/files/stored_campaign.hpp"

#include <nlohmann/json.hpp>
#include <set>

#include "store/session.hpp"
#include "store/transaction.hpp"

namespace trammel {

namespace {

/// Points of a session measured here: role by the seq of its readings.
std::map<int, std::string> roles_of(store::Connection& connection, const store::SessionRow& session,
                                    const std::vector<store::StoredReading>& readings) {
  if (session.n_points == 0) return store::imported_walk(session).roles;
  std::map<int, std::string> by_point;
  for (const store::Point& point : store::points(connection, session.id)) {
    by_point[point.seq] = point.role;
  }
  std::map<store::Id, std::string> by_attempt;
  for (const store::Attempt& attempt : store::attempts(connection, session.id)) {
    by_attempt[attempt.id] = by_point[attempt.point_seq];
  }
  std::map<int, std::string> roles;
  for (const store::StoredReading& reading : readings) {
    if (reading.session_id != session.id || !reading.attempt_id) continue;
    const std::string& role = by_attempt[*reading.attempt_id];
    if (!role.empty()) roles[reading.data.reading.seq] = role;
  }
  return roles;
}

}  // namespace

store::ImportResult store_campaign(store::Connection& connection, const CampaignFile& file) {
  store::Exchange exchange;
  exchange.sessions.clear();
  for (const FileSession& s : file.sessions) {
    exchange.sessions.push_back({.name = s.name,
                                 .compensation = s.compensation,
                                 .plan = s.plan,
                                 .n_asked = s.n_points,
                                 .held_epochs = s.held_epochs});
  }
  for (std::size_t k = 0; k < file.campaign.readings.size(); ++k) {
    const int seq = file.campaign.readings[k].seq;
    const std::size_t session = file.session_of.empty() ? 0 : file.session_of[k];
    exchange.session_of[seq] = session;
    if (!file.roles.empty() && !file.roles[k].empty()) {
      exchange.sessions[session].roles[seq] = file.roles[k];
    }
    if (!file.extras[k].empty()) exchange.extra_json[seq] = nlohmann::json(file.extras[k]).dump();
  }
  exchange.exclusions = file.exclusions;
  return store::import_campaign(connection, file.campaign, exchange);
}

CampaignFile stored_campaign(store::Connection& connection, const store::CampaignRow& campaign) {
  const store::Snapshot snapshot(connection);
  store::LoadedCampaign loaded =
      store::load_campaign(connection, campaign.id, {.sessions = {}, .with_excluded = true});
  const std::vector<store::StoredReading> readings = store::readings(connection, campaign.id);
  CampaignFile file;
  file.sessions.clear();
  std::map<store::Id, std::size_t> places;
  std::map<int, std::string> roles;
  std::set<int> has_readings;
  for (const store::StoredReading& r : readings)
    has_readings.insert(r.data.reading.conditions.epoch);
  for (const store::SessionRow& row : store::list_sessions(connection, campaign.id)) {
    if (row.n_readings == 0) continue;
    places[row.id] = file.sessions.size();
    FileSession session{.name = row.name,
                        .compensation = row.compensation_name,
                        .plan = row.plan_name,
                        .n_points = std::max(row.n_points, row.n_asked)};
    for (const store::Epoch& epoch : store::epochs(connection, row.id)) {
      if (epoch.held && has_readings.contains(epoch.number))
        session.held_epochs.push_back(epoch.number);
    }
    file.sessions.push_back(std::move(session));
    roles.merge(roles_of(connection, row, readings));
  }
  std::set<std::string> columns;
  for (const store::StoredReading& reading : readings) {
    std::map<std::string, std::string> extras;
    if (reading.data.extra_json) extras = nlohmann::json::parse(*reading.data.extra_json);
    for (const auto& [column, text] : extras) columns.insert(column);
    file.extras.push_back(std::move(extras));
    file.session_of.push_back(places.at(reading.session_id));
    if (!roles.empty()) file.roles.push_back(roles[reading.data.reading.seq]);
  }
  for (const store::Exclusion& e : loaded.exclusions) file.exclusions.emplace_back(e.seq, e.reason);
  file.extra_columns.assign(columns.begin(), columns.end());
  file.campaign = std::move(loaded.campaign);
  return file;
}

}  // namespace trammel
