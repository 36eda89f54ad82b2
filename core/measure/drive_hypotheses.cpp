#include "core/measure/drive_hypotheses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace trammel {

namespace {

std::string drives_in_words(const std::vector<int>& drives) {
  std::string text;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (i > 0) text += i + 1 == drives.size() ? " and " : ", ";
    text += std::to_string(drives[i] + 1);
  }
  return text;
}

}  // namespace

Displaced displacements_at(const DriveModel& model, const Pose& pose) {
  const InverseResult at = model.solver.drives(pose);
  if (!at.ok()) return std::nullopt;
  Displacements l = at.l_mm;
  if (!model.other_branch) return model.drives(l);
  const Geometry geometry = geometry_of(model.solver.machine());
  for (int i = 0; i < kChains; ++i) {
    const Chain& chain = geometry.chains[static_cast<std::size_t>(i)];
    // Q.u - root becomes Q.u + root; the link's angle says the root: S cos(alpha - theta)
    l[i] += 2 * chain.S_mm * std::cos(chain.alpha_rad - at.theta_rad[i]);
  }
  return model.drives(l);
}

std::vector<DriveHypothesis> hypotheses_of_drives(const MachineSolver& solver) {
  const int n = solver.machine().kind->n_chains;
  std::vector<DriveHypothesis> all;
  std::array<int, kChains> order;
  std::iota(order.begin(), order.end(), 0);
  while (std::next_permutation(order.begin(), order.begin() + n)) {
    std::vector<int> moved;
    for (int i = 0; i < kChains; ++i) {
      if (order[static_cast<std::size_t>(i)] != i) moved.push_back(i);
    }
    all.push_back({Mistake::drives_swapped,
                   "drives " + drives_in_words(moved) +
                       (moved.size() == 2 ? " are swapped" : " have changed places"),
                   {.solver = solver, .drives = [order](const Displacements& l) {
                      return Displacements(l[order[0]], l[order[1]], l[order[2]]);
                    }}});
  }
  for (unsigned signs = 1; signs < 1U << n; ++signs) {
    Displacements sign = Displacements::Ones();
    std::vector<int> reversed;
    for (int i = 0; i < kChains; ++i) {
      if ((signs >> i & 1U) == 0) continue;
      sign[i] = -1;
      reversed.push_back(i);
    }
    const bool one = reversed.size() == 1;
    all.push_back({Mistake::drive_reversed,
                   (one ? "drive " : "drives ") + drives_in_words(reversed) +
                       (one ? " counts backwards" : " count backwards"),
                   {.solver = solver, .drives = [sign](const Displacements& l) {
                      return Displacements(sign.cwiseProduct(l));  // its zero is a constant
                    }}});
  }
  if (!is_prr(solver)) return all;
  all.push_back({Mistake::working_mode,
                 "the links stand in the other working mode",
                 {.solver = solver, .other_branch = true}});
  return all;
}

}  // namespace trammel
