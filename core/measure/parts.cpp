// Mistakes of a part of a campaign: the rows of one set or epoch, or those that lie apart from the
// rest, came from another export than the others.

#include <algorithm>
#include <functional>
#include <set>

#include "core/measure/gross.hpp"
#include "core/measure/lie.hpp"
#include "core/measure/nominal_commands.hpp"
#include "core/measure/printed.hpp"
#include "core/statistics/robust.hpp"

namespace trammel {

namespace {

constexpr double kApart = 5;              // distances that leave out so wide a step are two groups
constexpr std::size_t kFewestApart = 12;  // chosen by their distance: more than kFewestScreened
constexpr double kFarFromTarget = 1;      // mm: nearer, rows apart are the robot's own errors
constexpr double kFarOfWidth = 0.03;  // the same of small machines, of the width of their targets

struct CampaignPart {
  std::string words;
  std::set<int> seqs = {};
  bool own_frame = false;    // an epoch has a frame of its own, which fits give it
  bool is_doubtful = false;  // a mistake without a name counts too
};

CampaignPart part_of(const Campaign& campaign, const std::string& words,
                     const std::function<bool(const Reading&)>& has) {
  CampaignPart part{.words = words};
  for (const Reading& r : campaign.readings) {
    if (r.measured && has(r)) part.seqs.insert(r.seq);
  }
  return part;
}

/// Poses less the median of what they are off their targets.
void take_median_off(const poses::Poses& targets, poses::Poses& measured) {
  std::vector<double> x, y, phi;
  for (std::size_t k = 0; k < targets.size(); ++k) {
    x.push_back(measured[k].x_mm - targets[k].x_mm);
    y.push_back(measured[k].y_mm - targets[k].y_mm);
    phi.push_back(poses::wrapped(measured[k].phi_rad - targets[k].phi_rad));
  }
  const Pose off{median(x), median(y), median(phi)};
  for (Pose& p : measured) p = Pose::from(p.vector() - off.vector());
}

/// Rows beyond the widest step of the sorted distances from the targets, or from where most rows
/// are off them, where it is one.
CampaignPart apart(const Campaign& campaign, bool from_most) {
  poses::Poses targets, measured;
  std::vector<int> seqs;
  for (const Reading& r : campaign.readings) {
    if (!r.measured) continue;
    targets.push_back(r.target);
    measured.push_back(*r.measured);
    seqs.push_back(r.seq);
  }
  if (seqs.size() < kFewestApart) return {};
  if (from_most) take_median_off(targets, measured);
  const std::vector<double> off_mm = poses::distances_mm(targets, measured);
  std::vector<double> sorted = off_mm;
  std::ranges::sort(sorted);
  const double far_mm =
      std::min(kFarFromTarget, kFarOfWidth * poses::lie(targets, measured).width_mm);
  double limit_mm = 0, widest = kApart;
  for (std::size_t k = 1; k + kFewestApart <= sorted.size(); ++k) {
    const double step = sorted[k] / std::max(sorted[k - 1], far_mm / kApart);
    if (step <= widest) continue;
    widest = step;
    limit_mm = sorted[k];
  }
  CampaignPart part{.words = {}};
  for (std::size_t k = 0; k < off_mm.size() && limit_mm > 0; ++k) {
    if (off_mm[k] >= limit_mm) part.seqs.insert(seqs[k]);
  }
  part.words = printed("%d readings", static_cast<int>(part.seqs.size()));
  return part;
}

/// Rows whose commands are not the nominal ones, where those of others are.
CampaignPart of_other_commands(const Campaign& campaign) {
  const std::vector<double> off_mm = command_off_mm(campaign);
  CampaignPart part{.words = {}};
  for (std::size_t k = 0; k < off_mm.size(); ++k) {
    const Reading& r = campaign.readings[k];
    if (r.measured && off_mm[k] > kNominalCommandMm) part.seqs.insert(r.seq);
  }
  part.words = printed("%d readings", static_cast<int>(part.seqs.size()));
  part.is_doubtful = true;
  return part;
}

std::vector<CampaignPart> campaign_parts(const Campaign& campaign) {
  std::vector<CampaignPart> parts;
  for (const auto& [set, words] : {std::pair(ReadingSet::identify, "identify readings"),
                                   std::pair(ReadingSet::validate, "validation readings")}) {
    parts.push_back(
        part_of(campaign, words, [set = set](const Reading& r) { return r.set == set; }));
  }
  std::set<int> epochs;
  for (const Reading& r : campaign.readings) epochs.insert(r.conditions.epoch);
  for (const int epoch : epochs) {
    parts.push_back(part_of(campaign, printed("readings of epoch %d", epoch),
                            [epoch](const Reading& r) { return r.conditions.epoch == epoch; }));
    parts.back().own_frame = true;
  }
  for (const bool from_most : {false, true}) parts.push_back(apart(campaign, from_most));
  parts.push_back(of_other_commands(campaign));
  return parts;
}

bool is_named(const Suspicion& s) { return s.kind != Mistake::mechanism; }

/// Of the first part that has one.
std::vector<Suspicion> mistakes_of_a_part(const Campaign& campaign, bool last_resort) {
  for (const CampaignPart& part : campaign_parts(campaign)) {
    Campaign some = campaign;
    std::erase_if(some.readings, [&](const Reading& r) { return !part.seqs.contains(r.seq); });
    if (some.readings.size() == campaign.readings.size()) continue;
    std::vector<Suspicion> found = gross_mistakes_of_all(some, last_resort);
    std::erase_if(found, [&](const Suspicion& s) {
      const bool frame = s.kind == Mistake::frame_turned || s.kind == Mistake::frame_shifted;
      return !(is_named(s) || part.is_doubtful) || (frame && part.own_frame);
    });
    if (found.empty()) continue;
    for (Suspicion& s : found) {
      s.what = "of the " + part.words + " alone: " + s.what;
      s.seqs.assign(part.seqs.begin(), part.seqs.end());
    }
    return found;
  }
  return {};
}

}  // namespace

std::vector<Suspicion> gross_mistakes(const Campaign& campaign) {
  std::vector<Suspicion> whole;
  for (const bool last_resort : {false, true}) {
    whole = gross_mistakes_of_all(campaign, last_resort);
    if (std::ranges::any_of(whole, is_named)) return whole;
    std::vector<Suspicion> found = mistakes_of_a_part(campaign, last_resort);
    if (!found.empty()) return found;
  }
  return whole;
}

}  // namespace trammel
