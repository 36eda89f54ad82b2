#pragma once

#include <filesystem>

#include "app/files/campaign_file.hpp"

namespace trammel {

/// Adds the readings of `path` to `file`, whose mechanism is known. Errors as read_campaign.
void read_readings_csv(const std::filesystem::path& path, CampaignFile& file);

/// All columns of the format that hold something, then the extra ones.
std::string readings_csv(const CampaignFile& file);

const char* set_name(ReadingSet set);

}  // namespace trammel
