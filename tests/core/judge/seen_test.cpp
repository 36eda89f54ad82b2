#include "core/judge/seen.hpp"

#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

Reading reading_of(const Pose& target, int epoch = 1, ReadingSet set = ReadingSet::identify) {
  Reading r;
  r.set = set;
  r.target = target;
  r.conditions.epoch = epoch;
  r.measured = target;
  return r;
}

}  // namespace

TEST_CASE("a target is itself after three decimals of text, and whole turns do not make another",
          "[judge]") {
  const Pose target{12.34567, -76.54321, rad_from_deg(3.21049)};
  CHECK(same_target(target, {12.346, -76.543, rad_from_deg(3.210)}));
  CHECK(same_target(target, {12.34567, -76.54321, target.phi_rad - 2 * kPi}));
  CHECK_FALSE(same_target(target, {12.3477, -76.54321, target.phi_rad}));
  CHECK_FALSE(same_target(target, {12.34567, -76.54321, rad_from_deg(3.2125)}));
}

TEST_CASE("targets are found as by looking at each, on either side of any cell", "[judge]") {
  Random random(3);
  std::vector<Pose> all;
  Targets targets;
  for (int k = 0; k < 300; ++k) {
    // A few places, each crossed by the edges of cells, in two orientations.
    const Pose near{0.0005 * static_cast<int>(random.uniform(-20, 20)),
                    0.0005 * static_cast<int>(random.uniform(-20, 20)),
                    random.uniform(0, 1) < 0.5 ? 0 : 0.1};
    const auto known = targets.find(near);
    bool any = false;
    for (const Pose& p : all) any = any || same_target(p, near);
    REQUIRE(known.has_value() == any);
    if (known) CHECK(same_target(all[*known], near));
    if (targets.add(near) == all.size()) all.push_back(near);
    REQUIRE(targets.size() == all.size());
  }
  CHECK(all.size() > 20);
}

TEST_CASE("a fit has seen its targets whatever the set is called, turned ones it has not",
          "[judge]") {
  const std::vector<Reading> taken = {reading_of({10, 20, 0})};
  const Seen seen(taken);
  CHECK(seen.standing(reading_of({10.0004, 20, 0}, 1, ReadingSet::validate)) == Standing::fitted);
  CHECK(seen.standing(reading_of({10, 20, 0.01}, 1, ReadingSet::validate)) == Standing::unseen);
  CHECK(seen.standing(reading_of({10.01, 20, 0}, 1, ReadingSet::identify)) == Standing::unseen);
}

TEST_CASE("an epoch is known by a reading of it, or where reference points held, over any chain",
          "[judge]") {
  const std::vector<Reading> taken = {reading_of({10, 20, 0}, 3)};
  const Reading in_epoch_1 = reading_of({0, 0, 0}, 1, ReadingSet::validate);
  CHECK(Seen(taken).standing(in_epoch_1) == Standing::unknown_epoch);
  CHECK(Seen(taken).standing(reading_of({0, 0, 0}, 3)) == Standing::unseen);
  CHECK(Seen(taken, {{1, 2}}).standing(in_epoch_1) == Standing::unknown_epoch);
  CHECK(Seen(taken, {{1, 2}, {2, 3}}).standing(in_epoch_1) == Standing::unseen);
  CHECK(Seen(taken, {}, true).standing(in_epoch_1) == Standing::unseen);
  // Measured again: what the robot does there is seen, whatever the set-up.
  CHECK(Seen(taken).standing(in_epoch_1.target) == Standing::unseen);
}
