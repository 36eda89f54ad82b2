#pragma once

#include "app/files/campaign_file.hpp"
#include "store/campaign.hpp"

namespace trammel {

/// Stores a campaign/1 with its x_ columns, all or nothing.
store::ImportResult store_campaign(store::Connection& connection, const CampaignFile& file);

/// A stored campaign as campaign/1, excluded readings too. Of a campaign measured here, the column
/// x_session says in which session a reading was taken.
CampaignFile stored_campaign(store::Connection& connection, const store::CampaignRow& campaign);

}  // namespace trammel
