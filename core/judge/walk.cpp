#include "core/judge/walk.hpp"

#include <algorithm>
#include <map>

#include "core/judge/seen.hpp"

namespace trammel {

namespace {

std::vector<const Visit*> pointers(const Walk& walk) {
  std::vector<const Visit*> all;
  all.reserve(walk.visits.size());
  for (const Visit& visit : walk.visits) all.push_back(&visit);
  return all;
}

int n_planned(const Walk& walk) {
  return std::max(walk.n_asked, static_cast<int>(walk.plan.size()));
}

}  // namespace

bool on_circle(const Visit& visit) { return visit.role.starts_with("circle"); }

bool complete(const Walk& walk) { return walk.n_done >= n_planned(walk); }

bool same_plan(const Walk& a, const Walk& b) {
  if (a.plan.empty() || b.plan.empty() || n_planned(a) != n_planned(b)) return false;
  for (std::size_t k = 0; k < std::min(a.plan.size(), b.plan.size()); ++k) {
    if (!same_target(a.plan[k], b.plan[k])) return false;
  }
  return true;
}

bool stands(std::span<const Walk* const> walks, std::size_t k) {
  const Walk& walk = *walks[k];
  if (walk.visits.empty()) return false;
  if (complete(walk)) return true;
  if (walk.compensation) return false;
  for (const Walk* other : walks) {
    const bool baseline = !other->compensation && !other->visits.empty();
    if (baseline && complete(*other) && same_plan(*other, walk)) return false;
  }
  return true;
}

std::optional<std::size_t> baseline_of(std::span<const Walk* const> walks, std::size_t k) {
  std::optional<std::size_t> best;
  std::size_t most = 0;
  for (std::size_t b = 0; b < walks.size(); ++b) {
    if (walks[b]->compensation || !stands(walks, b)) continue;
    const std::size_t shared =
        pair_visits(pointers(*walks[b]), walks[k]->visits, same_plan(*walks[b], *walks[k])).size();
    if (shared > most) {
      best = b;
      most = shared;
    }
  }
  return best;
}

VisitPairs pair_visits(std::span<const Visit* const> before, std::span<const Visit> after,
                       bool one_plan) {
  // Visits of one target (and of one point of one plan) in their order.
  Targets targets;
  std::map<std::pair<std::size_t, int>, std::vector<std::size_t>> waiting;
  for (std::size_t a = after.size(); a-- > 0;) {
    const std::size_t target = targets.add(after[a].reading.target);
    waiting[{target, one_plan ? after[a].point : 0}].push_back(a);  // the first is at the end
  }
  VisitPairs pairs;
  for (std::size_t b = 0; b < before.size(); ++b) {
    const auto target = targets.find(before[b]->reading.target);
    if (!target) continue;
    const auto found = waiting.find({*target, one_plan ? before[b]->point : 0});
    if (found == waiting.end() || found->second.empty()) continue;
    pairs.emplace_back(b, found->second.back());
    found->second.pop_back();
  }
  return pairs;
}

}  // namespace trammel
