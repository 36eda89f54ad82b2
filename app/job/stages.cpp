#include "app/job/stages.hpp"

#include <algorithm>

namespace trammel::job {

std::span<const Stage> stages() {
  static const std::vector<Stage> all = {lsq_stage(),     geometry_stage(), idw_stage(),
                                         rbf_stage(),     gp_stage(),       hybrid_stage(),
                                         contest_stage(), diagnose_stage()};
  return all;
}

const Stage& find_stage(const std::string& name) {
  std::string known;
  for (const Stage& stage : stages()) {
    if (stage.name == name) return stage;
    known += (known.empty() ? "" : ", ") + stage.name;
  }
  throw NotFoundError({.what = "there is no such calibration", .got = name, .expected = known});
}

std::vector<Reading> identify_rows(const Campaign& campaign) {
  std::vector<Reading> rows;
  rows.reserve(campaign.readings.size());
  for (const Reading& r : campaign.readings) {
    if (r.set == ReadingSet::identify && r.measured) rows.push_back(r);
  }
  if (rows.empty()) {
    throw InputError({.what = "there is nothing to calibrate from",
                      .got = std::to_string(campaign.readings.size()) +
                             " readings, none of them in the set 'identify'",
                      .expected = "measured readings of the set 'identify'",
                      .hint = "name other sessions with --session, or measure a baseline"});
  }
  return rows;
}

}  // namespace trammel::job
