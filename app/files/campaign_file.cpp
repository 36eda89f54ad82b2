#include "app/files/campaign_file.hpp"

#include "app/files/budget_json.hpp"
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

/// Bounds that no tracker leaves; below the least one, weights 1 / sigma^2 outrun what doubles
/// hold.
constexpr double kLeastSigma = 1e-9;
constexpr double kMostSigmaMm = 100;
constexpr double kMostSigmaDeg = 360;

void require_sigma(const Fields& fields, const char* name, double value, double most) {
  if (!(value > 0)) fields.refuse(name, "a sigma that is not positive");
  if (value >= kLeastSigma && value <= most) return;
  fields.refuse(name, "a sigma out of all bounds",
                number_text(kLeastSigma) + " to " + number_text(most), "is the unit right?");
}

TrackerSigma read_tracker(Fields fields) {
  const TrackerSigma sigma{fields.number("sigma_xy_mm"),
                           rad_from_deg(fields.number("sigma_phi_deg"))};
  require_sigma(fields, "sigma_xy_mm", sigma.xy_mm, kMostSigmaMm);
  require_sigma(fields, "sigma_phi_deg", deg_from_rad(sigma.phi_rad), kMostSigmaDeg);
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
    if (auto budget = facts->optional_object(kBudgetFact)) {
      campaign.facts[kBudgetFact] = read_budget(*budget);
    }
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
  if (const auto budget = campaign.facts.find(kBudgetFact); budget != campaign.facts.end()) {
    json["facts"][kBudgetFact] = nlohmann::ordered_json::parse(budget->second);
  }
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
