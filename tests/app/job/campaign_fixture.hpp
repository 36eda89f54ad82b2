#pragma once
// A stored campaign that was made here: the paper's points on a robot with geometric errors.

#include "app/job/stages.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/store/fixtures.hpp"

namespace trammel::tests {

inline Campaign paper_campaign(const std::string& name = "paper") {
  Random random(71);
  Campaign campaign;
  campaign.name = name;
  campaign.simulated = true;
  campaign.machine = machine_of(paper_mechanism());
  campaign.tracker = kSigma;
  const Geometry truth = random_geometry(random);
  std::vector<Pose> targets = eighty_points();
  for (int k = 0; k < 48; ++k) {
    targets.push_back({random.uniform(-80, 80), random.uniform(-80, 80), 0});
  }
  campaign.readings = measure(truth, targets, random);
  for (std::size_t k = 80; k < 128; ++k) campaign.readings[k].set = ReadingSet::validate;
  return campaign;
}

/// A database with that campaign imported.
struct PaperStore {
  test::TempFolder folder;
  store::Connection db = store::open(folder.file("t.db"), store::Access::create);
  store::Id campaign = store::import_campaign(db, paper_campaign()).campaign_id;
};

/// The sentences of a result, one per line.
inline std::string said(const job::StageResult& result) {
  std::string text;
  for (const std::string& sentence : result.words) text += sentence + "\n";
  return text;
}

}  // namespace trammel::tests
