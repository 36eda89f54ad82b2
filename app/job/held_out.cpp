#include "app/job/held_out.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace trammel::job {

std::vector<Pose> held_out_poses(const Fit& fit, const Campaign& campaign,
                                 std::span<const Reading> rows, const std::vector<int>& block) {
  std::vector<Pose> poses(rows.size());
  const int n_blocks = 1 + *std::max_element(block.begin(), block.end());
  for (int out = 0; out < n_blocks; ++out) {
    Campaign training = campaign;
    training.readings.clear();
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (block[k] != out) training.readings.push_back(rows[k]);
    }
    const Correction correction = fit(training);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (block[k] != out) continue;
      const auto after = predicted_after(correction, campaign.machine, rows[k]);
      if (!after) throw InputError({.what = "a corrected target is out of reach"});
      poses[k] = *after;
    }
  }
  return poses;
}

}  // namespace trammel::job
