#include "core/judge/walk.hpp"

#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// A walk over points (10 k, y, 0), of which the first n_done were measured.
Walk walk_of(int n_points, int n_done, std::optional<std::int64_t> compensation = {},
             double y_mm = 0) {
  Walk walk{.compensation = compensation, .n_done = n_done};
  for (int k = 1; k <= n_points; ++k) {
    walk.plan.push_back({10.0 * k, y_mm, 0});
    if (k > n_done) continue;
    Reading r;
    r.target = walk.plan.back();
    r.measured = r.target;
    walk.visits.push_back({.point = k, .role = "grid", .reading = r});
  }
  return walk;
}

std::vector<const Visit*> pointers_to(const Walk& walk) {
  std::vector<const Visit*> all;
  for (const Visit& v : walk.visits) all.push_back(&v);
  return all;
}

}  // namespace

TEST_CASE("the last complete walk stands: one that was stopped or has no reading changes nothing",
          "[judge]") {
  const Walk baseline = walk_of(48, 48), repeated = walk_of(48, 13), again = walk_of(48, 48, 7),
             stopped = walk_of(48, 13, 7), empty = walk_of(48, 0, 7), other = walk_of(9, 4, {}, 5);
  const std::vector<const Walk*> walks = {&baseline, &repeated, &again, &stopped, &empty, &other};
  CHECK(stands(walks, 0));
  CHECK_FALSE(stands(walks, 1));
  CHECK(stands(walks, 2));
  CHECK_FALSE(stands(walks, 3));
  CHECK_FALSE(stands(walks, 4));
  CHECK(stands(walks, 5));  // the only one of its plan: it stands as far as it went
  CHECK(baseline_of(walks, 2) == 0U);
}

TEST_CASE("a walk is compared with the baseline that shares most of it, of equals the first",
          "[judge]") {
  const Walk small = walk_of(3, 3), large = walk_of(8, 8), equal = walk_of(8, 8),
             apart = walk_of(20, 20, {}, 50), again = walk_of(6, 6, 1);
  const std::vector<const Walk*> walks = {&small, &apart, &large, &equal, &again};
  CHECK(baseline_of(walks, 4) == 2U);
  const std::vector<const Walk*> strange = {&apart, &again};
  CHECK_FALSE(baseline_of(strange, 1));
}

TEST_CASE("points of one plan pair by number, other visits in their order", "[judge]") {
  Walk before = walk_of(4, 4), after = walk_of(4, 4, 1);
  after.visits.erase(after.visits.begin() + 1);  // excluded
  after.visits[0].reading.target.x_mm += 4e-4;   // through text
  const VisitPairs pairs = pair_visits(pointers_to(before), after.visits, same_plan(before, after));
  CHECK(pairs == VisitPairs{{0, 0}, {2, 1}, {3, 2}});

  // One target three times before, twice after, without a plan.
  Walk many;
  for (int k = 0; k < 3; ++k) many.visits.push_back(before.visits[0]);
  const Walk twice{.compensation = 1, .visits = {before.visits[0], before.visits[0]}};
  CHECK(pair_visits(pointers_to(many), twice.visits, false) == VisitPairs{{0, 0}, {1, 1}});
  CHECK(complete(many));
}
