#include "app/files/campaign_file.hpp"

#include <algorithm>
#include <set>

#include "app/files/budget_json.hpp"
#include "app/files/fields.hpp"
#include "app/files/files.hpp"
#include "app/files/format.hpp"
#include "app/files/machine_json.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/numbers.hpp"
#include "app/files/readings_csv.hpp"
#include "core/measure/gross.hpp"
#include "core/measure/nominal_commands.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

/// Bounds that no tracker leaves; below the least one, weights 1 / sigma^2 outrun what doubles
/// hold.
constexpr double kLeastSigma = 1e-9;
constexpr double kMostSigmaMm = 100;
constexpr double kMostSigmaDeg = 360;
constexpr double kFarthestMm = 1e6;  // a command, where no limits are stated

void require_sigma(const Fields& fields, const char* name, double value, double most) {
  if (!(value > 0)) fields.refuse(name, "a sigma that is not positive");
  if (value >= kLeastSigma && value <= most) return;
  fields.refuse(name, "a sigma out of all bounds",
                number_text(kLeastSigma) + " to " + number_text(most), "is the unit right?");
}

TrackerSigma read_tracker(Fields fields, const Coordinates& measured) {
  TrackerSigma sigma{.xy_mm = fields.number("sigma_xy_mm")};
  require_sigma(fields, "sigma_xy_mm", sigma.xy_mm, kMostSigmaMm);
  if (measured[2]) {
    sigma.phi_rad = rad_from_deg(fields.number("sigma_phi_deg"));
    require_sigma(fields, "sigma_phi_deg", deg_from_rad(sigma.phi_rad), kMostSigmaDeg);
  } else if (fields.has("sigma_phi_deg")) {
    fields.refuse("sigma_phi_deg", "phi is not measured");
  }
  fields.done();
  return sigma;
}

/// {"name", "plan", "n_points", "held_epochs"}; under which correction, the readings say.
FileSession read_session(Fields& fields) {
  FileSession session{.name = fields.text("name"), .plan = fields.text("plan", "")};
  session.n_points = fields.integer("n_points", 0);
  if (session.n_points < 0) fields.refuse("n_points", "a negative number of points");
  if (fields.has("held_epochs")) {
    for (const double number : fields.numbers("held_epochs")) {
      const int epoch = static_cast<int>(std::clamp(number, 0.0, 1e9));
      if (epoch != number) fields.refuse("held_epochs", "an epoch that is no whole number");
      session.held_epochs.push_back(epoch);
    }
  }
  fields.done();
  return session;
}

/// What only campaign/2 has.
void read_walks(Fields& top, CampaignFile& file) {
  file.campaign.machine = read_campaign_machine(top);
  if (top.has("sessions")) {
    file.sessions.clear();
    for (Fields& session : top.objects("sessions")) file.sessions.push_back(read_session(session));
  }
  if (!top.has("exclusions")) return;
  for (Fields& exclusion : top.objects("exclusions")) {
    file.exclusions.emplace_back(exclusion.integer("seq"), exclusion.text("reason"));
    exclusion.done();
  }
}

/// What the readings need of campaign.json.
struct Head {
  std::string readings;  // their file
  bool states_limits = true;
};

Head read_head(const JsonFile& json, CampaignFile& file) {
  Head head;
  Fields top(json);
  file.format = top.has("format") && top.text("format") == "campaign/1" ? 1 : 2;
  take_format(top, file.format == 1 ? "campaign/1" : "campaign/2");
  Campaign& campaign = file.campaign;
  campaign.name = top.text("name");
  if (campaign.name.empty() || campaign.name.size() > 200) {
    top.refuse("name", "a name that can't be used", "1 to 200 letters");
  }
  campaign.simulated = top.choice("kind", {"real", "simulated"}) == "simulated";
  if (file.format == 1) {
    Fields mechanism = top.object("mechanism");
    head.states_limits = mechanism.has("limits");
    campaign.machine = machine_of(read_mechanism(std::move(mechanism)));
  } else {
    read_walks(top, file);
  }
  if (auto tracker = top.optional_object("tracker")) {
    if (tracker->has("sigma_xy_mm") || tracker->has("sigma_phi_deg")) {
      campaign.tracker = read_tracker(*tracker, campaign.machine.measured);
    } else {
      tracker->done();
    }
  }
  if (auto facts = top.optional_object("facts")) {
    if (auto budget = facts->optional_object(kBudgetFact)) {
      campaign.facts[kBudgetFact] = read_budget(*budget);
    }
    for (auto& [key, value] : facts->text_pairs()) campaign.facts[key] = value;
  }
  head.readings = top.text("readings");
  top.done();
  return head;
}

/// Drives whose limits nobody stated reach as far as they went.
void widen_limits(Campaign& campaign) {
  for (std::size_t i = 0; i < campaign.machine.drives.size(); ++i) {
    Limits& limits = campaign.machine.drives[i].limits;
    limits = Limits{};
    for (const Reading& r : campaign.readings) {
      const double l_mm = r.conditions.cmd_mm[static_cast<Eigen::Index>(i)];
      limits.l_min_mm = std::min(limits.l_min_mm, l_mm);
      limits.l_max_mm = std::max(limits.l_max_mm, l_mm);
    }
  }
}

std::size_t session_of(const CampaignFile& file, std::size_t reading) {
  return file.session_of.empty() ? 0 : file.session_of[reading];
}

void require_epochs_held(const CampaignFile& file, const std::string& path) {
  std::set<int> known;
  for (const Reading& r : file.campaign.readings) known.insert(r.conditions.epoch);
  for (const FileSession& session : file.sessions) {
    for (const int epoch : session.held_epochs) {
      if (known.contains(epoch)) continue;
      throw InputError({.what = "an epoch of which there is no reading",
                        .where = {.file = path, .field = "sessions.held_epochs"},
                        .got = std::to_string(epoch),
                        .expected = "epochs of the readings"});
    }
  }
}

/// campaign/1 does not say what was measured under a correction: those rows are a walk of their
/// own.
void set_corrected_apart(CampaignFile& file) {
  const std::vector<std::size_t> corrected = under_a_correction(file.campaign);
  if (corrected.empty() || is_gross(gross_mistakes(file.campaign))) return;
  file.sessions.push_back(
      {.name = "import, corrected", .compensation = "a correction that the file does not name"});
  file.session_of.assign(file.campaign.readings.size(), 0);
  for (const std::size_t k : corrected) file.session_of[k] = 1;
}

nlohmann::ordered_json sessions_json(const CampaignFile& file) {
  auto all = nlohmann::ordered_json::array();
  for (const FileSession& s : file.sessions) {
    nlohmann::ordered_json session = {{"name", s.name}};
    if (!s.plan.empty()) session["plan"] = s.plan;
    if (s.n_points > 0) session["n_points"] = s.n_points;
    if (!s.held_epochs.empty()) session["held_epochs"] = s.held_epochs;
    all.push_back(std::move(session));
  }
  return all;
}

std::string head_json(const CampaignFile& file) {
  const Campaign& campaign = file.campaign;
  nlohmann::ordered_json json = {{"format", "campaign/2"},
                                 {"name", campaign.name},
                                 {"kind", campaign.simulated ? "simulated" : "real"}};
  write_campaign_machine(campaign.machine, json);
  if (campaign.tracker) {
    json["tracker"]["sigma_xy_mm"] = campaign.tracker->xy_mm;
    if (campaign.machine.measured[2]) {
      json["tracker"]["sigma_phi_deg"] = exact_deg(campaign.tracker->phi_rad);
    }
  }
  if (!campaign.facts.empty()) json["facts"] = campaign.facts;
  if (const auto budget = campaign.facts.find(kBudgetFact); budget != campaign.facts.end()) {
    json["facts"][kBudgetFact] = nlohmann::ordered_json::parse(budget->second);
  }
  json["sessions"] = sessions_json(file);
  for (const auto& [seq, reason] : file.exclusions) {
    json["exclusions"].push_back({{"seq", seq}, {"reason", reason}});
  }
  json["readings"] = "readings.csv";
  return json.dump(2) + "\n";
}

/// Neither a visit of a reference point nor excluded.
bool is_judged(const CampaignFile& file, std::size_t reading) {
  if (!file.roles.empty() && file.roles[reading].starts_with("reference")) return false;
  const int seq = file.campaign.readings[reading].seq;
  return std::ranges::none_of(file.exclusions,
                              [seq](const auto& exclusion) { return exclusion.first == seq; });
}

}  // namespace

CampaignFile read_campaign(const std::filesystem::path& folder_or_file) {
  namespace fs = std::filesystem;
  const fs::path path =
      fs::is_directory(folder_or_file) ? folder_or_file / "campaign.json" : folder_or_file;
  CampaignFile file;
  const Head head = read_head(read_json(path), file);
  if (!head.states_limits) {
    for (Drive& drive : file.campaign.machine.drives) drive.limits = {-kFarthestMm, kFarthestMm};
  }
  read_readings_csv(path.parent_path() / head.readings, file);
  if (!head.states_limits) widen_limits(file.campaign);
  require_epochs_held(file, path.string());
  if (file.format == 1) set_corrected_apart(file);
  return file;
}

Campaign baseline_of(const CampaignFile& file) {
  Campaign campaign = file.campaign;
  campaign.readings.clear();
  for (std::size_t k = 0; k < file.campaign.readings.size(); ++k) {
    if (file.sessions[session_of(file, k)].compensation.empty() && is_judged(file, k))
      campaign.readings.push_back(file.campaign.readings[k]);
  }
  return campaign;
}

std::vector<Suspicion> screened(const CampaignFile& file) {
  std::vector<CorrectedWalk> corrected;
  for (std::size_t s = 0; s < file.sessions.size(); ++s) {
    if (file.sessions[s].compensation.empty()) continue;
    CorrectedWalk walk{.name = file.sessions[s].name, .readings = {}};
    for (std::size_t k = 0; k < file.campaign.readings.size(); ++k) {
      if (session_of(file, k) == s && is_judged(file, k))
        walk.readings.push_back(file.campaign.readings[k]);
    }
    corrected.push_back(std::move(walk));
  }
  return screened(baseline_of(file), held_epochs_of(file), corrected);
}

std::vector<std::pair<int, int>> held_epochs_of(const CampaignFile& file) {
  std::vector<std::set<int>> epochs(file.sessions.size());
  for (std::size_t k = 0; k < file.campaign.readings.size(); ++k)
    epochs[session_of(file, k)].insert(file.campaign.readings[k].conditions.epoch);
  std::vector<std::pair<int, int>> held;
  for (std::size_t s = 0; s < epochs.size(); ++s) {
    for (const int epoch : file.sessions[s].held_epochs) {
      for (const int before : epochs[s]) {
        if (before < epoch) held.emplace_back(before, epoch);
      }
    }
  }
  return held;
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
  write_output(folder / "campaign.json", head_json(file), existing);
}

}  // namespace trammel
