#include "core/measure/screen.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "core/measure/bad_readings.hpp"
#include "core/measure/doubts.hpp"
#include "core/measure/gross.hpp"
#include "core/measure/held_epochs.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr const char* kWiring = "put the wiring or the columns right, and measure or export again";
constexpr const char* kFrame =
    "if this is the tracker's own frame, import with --frame fit; else export in the robot's frame";
constexpr const char* kUnits = "convert the columns to mm and deg, and import again";
constexpr const char* kColumns = "put the columns right, and import again";
constexpr const char* kExclude =
    "look at it; `trammel reading exclude` or `calibrate --without-suspects` leaves it out";

constexpr std::array<MistakeRule, 26> kRules = {{
    {Mistake::drives_swapped, "drives_swapped", Gravity::gross, kWiring},
    {Mistake::drive_reversed, "drive_reversed", Gravity::gross, kWiring},
    {Mistake::phi_offset, "phi_offset", Gravity::gross, "state orientations from the robot's X"},
    {Mistake::frame_turned, "frame_turned", Gravity::gross, kFrame},
    {Mistake::frame_shifted, "frame_shifted", Gravity::gross, kFrame},
    {Mistake::frame_mirrored, "frame_mirrored", Gravity::gross,
     "export in a right-handed frame seen from above, with the robot's X and Y"},
    {Mistake::scale, "scale", Gravity::gross, kUnits},
    {Mistake::radians, "radians", Gravity::gross, kUnits},
    {Mistake::working_mode, "working_mode", Gravity::gross,
     "compute the commands with cos(alpha - theta) > 0 (core/README.md)"},
    {Mistake::exchanged, "exchanged", Gravity::gross, kColumns},
    {Mistake::deviations, "deviations", Gravity::gross, "add the targets, and import again"},
    {Mistake::shifted_rows, "shifted_rows", Gravity::gross, kColumns},
    {Mistake::mechanism, "mechanism", Gravity::gross,
     "state the mechanism that the commands were computed with"},
    {Mistake::nominal, "nominal", Gravity::doubt, "export what was measured, not the nominals"},
    {Mistake::sigma_unit, "sigma_unit", Gravity::doubt,
     "state tracker.sigma_xy_mm in mm and tracker.sigma_phi_deg in deg"},
    {Mistake::temperature_unit, "temperature_unit", Gravity::doubt,
     "state temp_degc in deg C, and leave the cell empty where it was not read"},
    {Mistake::clock, "clock", Gravity::doubt,
     "put time_s right: drift and temperature effects follow it"},
    {Mistake::duplicated, "duplicated", Gravity::doubt,
     "a copied row tells nothing new: exclude all but one"},
    {Mistake::copied, "copied", Gravity::doubt, "validate on readings that no fit has seen"},
    {Mistake::unknown_epoch, "unknown_epoch", Gravity::doubt,
     "identify from readings of that epoch as well"},
    {Mistake::moved_frame, "moved_frame", Gravity::doubt,
     "if the frame or the homing changed between them, give these rows an epoch of their own"},
    {Mistake::other_commands, "other_commands", Gravity::remark,
     "those under a correction are a walk of their own and no baseline; where all are of another "
     "model they count as baseline: state the mechanism they were made with"},
    {Mistake::missing_cells, "missing_cells", Gravity::remark,
     "what needs them uses the readings that have them"},
    {Mistake::stale, "stale", Gravity::doubt, kExclude},
    {Mistake::missed, "missed", Gravity::doubt, kExclude},
    {Mistake::far, "far", Gravity::doubt, kExclude},
}};

}  // namespace

std::span<const MistakeRule> mistake_rules() { return kRules; }

const MistakeRule& rule_of(Mistake mistake) {
  const auto rule = std::ranges::find(kRules, mistake, &MistakeRule::mistake);
  TRAMMEL_ASSERT(rule != kRules.end());
  return *rule;
}

std::string to_string(Mistake mistake) { return rule_of(mistake).name; }

std::string to_string(Gravity gravity) {
  constexpr const char* kNames[] = {"gross", "doubt", "remark"};
  return kNames[static_cast<std::size_t>(gravity)];
}

namespace {

std::vector<Suspicion> screened_walks(const Campaign& as_measured,
                                      std::span<const std::pair<int, int>> held) {
  Campaign campaign = completed(as_measured);
  renumber(campaign.readings, first_epochs(held));
  std::vector<Suspicion> found = gross_mistakes(campaign);
  if (found.empty()) found = bad_readings(campaign);
  for (Suspicion& doubt : doubts(campaign, found)) found.push_back(std::move(doubt));
  return found;
}

/// What is no mistake of a walk under a correction: another model commands it, and it judges that.
bool is_of_baseline(Mistake kind) {
  return kind == Mistake::other_commands || kind == Mistake::unknown_epoch ||
         kind == Mistake::missing_cells;
}

/// What is found in one walk under a correction and not said of all others already.
std::vector<Suspicion> found_in(const CorrectedWalk& walk, Campaign campaign,
                                std::span<const std::pair<int, int>> held,
                                const std::vector<Suspicion>& known) {
  campaign.readings = walk.readings;
  std::vector<Suspicion> found = screened_walks(campaign, held);
  std::erase_if(found, [&](const Suspicion& s) {
    const bool said = std::ranges::any_of(known, [&](const Suspicion& k) {
      return k.seqs.empty() && k.kind == s.kind && k.what == s.what;
    });
    return is_of_baseline(s.kind) || said;
  });
  for (Suspicion& s : found) {
    if (s.seqs.size() == 1) continue;  // of one reading: it says which
    s.what = "of the walk " + walk.name + " under a correction: " + s.what;
    if (!s.seqs.empty()) continue;
    for (const Reading& r : walk.readings) s.seqs.push_back(r.seq);
  }
  return found;
}

}  // namespace

std::vector<Suspicion> screened(const Campaign& campaign, std::span<const std::pair<int, int>> held,
                                std::span<const CorrectedWalk> corrected) {
  std::vector<Suspicion> found = screened_walks(campaign, held);
  if (!is_gross(found)) {
    const std::vector<Suspicion> known = found;
    for (const CorrectedWalk& walk : corrected) {
      for (Suspicion& s : found_in(walk, campaign, held, known)) found.push_back(std::move(s));
    }
  }
  std::ranges::stable_sort(
      found, {}, [](const Suspicion& s) { return std::pair(rule_of(s.kind).gravity, s.kind); });
  return found;
}

bool is_gross(const std::vector<Suspicion>& found) {
  return std::ranges::any_of(
      found, [](const Suspicion& s) { return rule_of(s.kind).gravity == Gravity::gross; });
}

std::string seqs_in_words(const std::vector<int>& seqs) {
  constexpr std::size_t kNamed = 8;
  if (seqs.empty()) return "all readings";
  std::string text = seqs.size() == 1 ? "seq " : "seqs ";
  for (std::size_t k = 0; k < std::min(seqs.size(), kNamed); ++k)
    text += (k == 0 ? "" : ", ") + std::to_string(seqs[k]);
  if (seqs.size() > kNamed) text += " and " + std::to_string(seqs.size() - kNamed) + " more";
  return text;
}

std::string in_words(const Suspicion& found) {
  const MistakeRule& rule = rule_of(found.kind);
  return std::string(rule.name) + ": " + found.what + " (" + seqs_in_words(found.seqs) +
         "): " + found.why + "; " + rule.advice;
}

std::string gross_in_words(const std::vector<Suspicion>& found) {
  std::string text;
  for (const Suspicion& s : found) {
    if (rule_of(s.kind).gravity == Gravity::gross)
      text += (text.empty() ? "" : "; or ") + in_words(s);
  }
  return text;
}

void require_sound(const Campaign& campaign, const std::vector<Suspicion>& found,
                   const std::string& hint) {
  if (!is_gross(found)) return;
  throw InputError({.what = "the screen refuses these readings: " + gross_in_words(found),
                    .where = {.field = campaign.name},
                    .expected = "poses that belong to their targets and commands",
                    .hint = hint});
}

double near_target_rad(double phi_rad, double target_rad) {
  if (std::abs(phi_rad - target_rad) <= kPi) return phi_rad;
  return target_rad + std::remainder(phi_rad - target_rad, 2 * kPi);
}

}  // namespace trammel
