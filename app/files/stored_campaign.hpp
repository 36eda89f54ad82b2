#pragma once

#include "app/files/campaign_file.hpp"
#include "store/campaign.hpp"

namespace trammel {

/// Stores a campaign with its walks, exclusions and x_ columns, all or nothing.
store::ImportResult store_campaign(store::Connection& connection, const CampaignFile& file);

/// A stored campaign as campaign/2, excluded readings too. Stored elsewhere it is judged alike: the
/// same walks, pairs and figures of what was measured (speakers_agree_test.cpp); jobs stay here.
CampaignFile stored_campaign(store::Connection& connection, const store::CampaignRow& campaign);

}  // namespace trammel
