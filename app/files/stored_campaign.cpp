#include "app/files/stored_campaign.hpp"

#include <nlohmann/json.hpp>
#include <set>

#include "store/session.hpp"
#include "store/transaction.hpp"

namespace trammel {

store::ImportResult store_campaign(store::Connection& connection, const CampaignFile& file) {
  std::map<int, std::string> extra_json;
  for (std::size_t k = 0; k < file.extras.size(); ++k) {
    if (file.extras[k].empty()) continue;
    extra_json[file.campaign.readings[k].seq] = nlohmann::json(file.extras[k]).dump();
  }
  return store::import_campaign(connection, file.campaign, extra_json);
}

CampaignFile stored_campaign(store::Connection& connection, const store::CampaignRow& campaign) {
  const store::Snapshot snapshot(connection);
  store::LoadedCampaign loaded =
      store::load_campaign(connection, campaign.id, {.sessions = {}, .with_excluded = true});
  std::map<store::Id, std::string> session_names;
  for (const auto& session : store::session_names(connection, campaign.id)) {
    session_names[session.id] = session.name;
  }
  CampaignFile file;
  std::set<std::string> columns;
  for (const store::StoredReading& reading : store::readings(connection, campaign.id)) {
    std::map<std::string, std::string> extras;
    if (reading.data.extra_json) extras = nlohmann::json::parse(*reading.data.extra_json);
    if (!campaign.imported) extras["x_session"] = session_names[reading.session_id];
    for (const auto& [column, text] : extras) columns.insert(column);
    file.extras.push_back(std::move(extras));
  }
  file.extra_columns.assign(columns.begin(), columns.end());
  file.campaign = std::move(loaded.campaign);
  return file;
}

}  // namespace trammel
