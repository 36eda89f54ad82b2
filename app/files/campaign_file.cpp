#include "app/files/campaign_file.hpp"

#include "app/files/fields.hpp"
#include "app/files/files.hpp"
#include "app/files/format.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/numbers.hpp"
#include "app/files/readings_csv.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr const char* kFormat = "campaign/1";

TrackerSigma read_tracker(Fields fields) {
  const TrackerSigma sigma{fields.number("sigma_xy_mm"),
                           rad_from_deg(fields.number("sigma_phi_deg"))};
  if (!(sigma.xy_mm > 0)) fields.refuse("sigma_xy_mm", "a sigma that is not positive");
  if (!(sigma.phi_rad > 0)) fields.refuse("sigma_phi_deg", "a sigma that is not positive");
  fields.done();
  return sigma;
}

/// The campaign without its readings, and the readings' file.
std::string read_head(const JsonFile& file, Campaign& campaign) {
  Fields top(file);
  take_format(top, kFormat);
  campaign.name = top.text("name");
  if (campaign.name.empty() || campaign.name.size() > 200) {
    top.refuse("name", "a name that can't be used", "1 to 200 letters");
  }
  campaign.simulated = top.choice("kind", {"real", "simulated"}) == "simulated";
  campaign.mechanism = read_mechanism(top.object("mechanism"));
  if (auto tracker = top.optional_object("tracker")) campaign.tracker = read_tracker(*tracker);
  if (auto facts = top.optional_object("facts")) {
    for (auto& [key, value] : facts->text_pairs()) campaign.facts[key] = value;
  }
  const std::string readings = top.text("readings");
  top.done();
  return readings;
}

std::string head_json(const Campaign& campaign) {
  nlohmann::ordered_json json = {{"format", kFormat},
                                 {"name", campaign.name},
                                 {"kind", campaign.simulated ? "simulated" : "real"},
                                 {"mechanism", mechanism_json(campaign.mechanism)}};
  if (campaign.tracker) {
    json["tracker"] = {{"sigma_xy_mm", campaign.tracker->xy_mm},
                       {"sigma_phi_deg", exact_deg(campaign.tracker->phi_rad)}};
  }
  if (!campaign.facts.empty()) json["facts"] = campaign.facts;
  json["readings"] = "readings.csv";
  return json.dump(2) + "\n";
}

}  // namespace

CampaignFile read_campaign(const std::filesystem::path& folder_or_file) {
  namespace fs = std::filesystem;
  const fs::path path =
      fs::is_directory(folder_or_file) ? folder_or_file / "campaign.json" : folder_or_file;
  CampaignFile file;
  const std::string readings = read_head(read_json(path), file.campaign);
  read_readings_csv(path.parent_path() / readings, file);
  return file;
}

void write_campaign(const CampaignFile& file, const std::filesystem::path& folder,
                    Existing existing) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw StoreError({.what = "could not make the folder: " + error.message(),
                      .where = {.file = folder.string()}});
  }
  write_output(folder / "readings.csv", readings_csv(file), existing);
  write_output(folder / "campaign.json", head_json(file.campaign), existing);
}

}  // namespace trammel
