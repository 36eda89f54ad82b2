#include "core/measure/noise.hpp"

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// `places` commands, each read `times` times about a pose of its own.
std::vector<Reading> repeats(int places, int times, double xy_mm, double phi_rad,
                             std::uint64_t seed = 51) {
  Random random(seed);
  std::vector<Reading> readings;
  for (int place = 0; place < places; ++place) {
    for (int k = 0; k < times; ++k) {
      Reading r;
      r.seq = static_cast<int>(readings.size()) + 1;
      r.conditions.cmd_mm = Displacements::Constant(10.0 * place);
      r.conditions.from_mm = r.conditions.cmd_mm - Displacements::Constant(5);
      r.measured = Pose{place + xy_mm * random.normal(), -place + xy_mm * random.normal(),
                        phi_rad * random.normal()};
      readings.push_back(r);
    }
  }
  return readings;
}

}  // namespace

TEST_CASE("repeats tell the sigmas that were put in", "[measure]") {
  const auto noise = pooled_noise(repeats(50, 5, 0.010, 1e-4));
  REQUIRE(noise);
  CHECK(noise->degrees_of_freedom == 200);
  CHECK(noise->groups == 50);
  // relative standard errors 1/sqrt(2 * 400) and 1/sqrt(2 * 200); five of them
  CHECK_THAT(noise->sigma.xy_mm, WithinRel(0.010, 0.18));
  CHECK_THAT(noise->sigma.phi_rad, WithinRel(1e-4, 0.25));
}

TEST_CASE("another approach, epoch or command is no repeat; one repeat counts one", "[measure]") {
  auto readings = repeats(1, 2, 0.01, 1e-4);
  CHECK(pooled_noise(readings)->degrees_of_freedom == 1);
  readings[1].conditions.from_mm = readings[1].conditions.cmd_mm + Displacements::Constant(5);
  CHECK_FALSE(pooled_noise(readings));
  readings = repeats(1, 2, 0.01, 1e-4);
  readings[1].conditions.epoch = 2;
  CHECK_FALSE(pooled_noise(readings));
  CHECK_FALSE(pooled_noise(repeats(5, 1, 0.01, 1e-4)));
}

TEST_CASE("what is stated stands until repeats exceed it, once in 100 sound campaigns",
          "[measure]") {
  Campaign campaign;
  campaign.machine.measured = {true, true, true};
  campaign.tracker = TrackerSigma{0.010, rad_from_deg(0.004)};
  int overruled = 0, doubted = 0;
  constexpr int kTrials = 1000;
  for (int trial = 0; trial < kTrials; ++trial) {
    campaign.readings =
        repeats(20, 3, 0.010, rad_from_deg(0.004), static_cast<std::uint64_t>(100 + trial));
    const NoiseLevel level = noise_level(campaign);
    overruled += level.source == NoiseLevel::Source::repeats ? 1 : 0;
    doubted += level.doubted ? 1 : 0;
  }
  INFO(overruled << " overruled, " << doubted << " doubted");
  // two tests of 1 % each way: 20 +- 4.4
  CHECK(overruled <= 38);
  CHECK(overruled >= 5);
  CHECK(doubted <= 38);
  CHECK(doubted >= 5);
}

TEST_CASE("repeats beyond what is stated are used, repeats below doubt it, few decide nothing",
          "[measure]") {
  Campaign campaign;
  campaign.machine.measured = {true, true, true};
  campaign.tracker = TrackerSigma{0.010, rad_from_deg(0.004)};
  campaign.readings = repeats(20, 5, 0.0197, rad_from_deg(0.004));
  const NoiseLevel beyond = noise_level(campaign);
  CHECK(beyond.source == NoiseLevel::Source::repeats);
  CHECK(beyond.degrees_of_freedom == 80);
  CHECK_THAT(beyond.sigma.xy_mm, WithinRel(0.0197, 0.2));
  CHECK(beyond.sigma.phi_rad == rad_from_deg(0.004));  // phi stands
  CHECK_THAT(beyond.words, Contains("beyond the stated 0.0100 mm"));
  campaign.readings = repeats(20, 5, 0.0011, rad_from_deg(0.004));
  const NoiseLevel below = noise_level(campaign);
  CHECK(below.source == NoiseLevel::Source::tracker);
  CHECK(below.sigma.xy_mm == 0.010);
  CHECK_THAT(below.words, Contains("is sigma in the right unit?"));
  campaign.readings = repeats(9, 2, 0.05, rad_from_deg(0.004));
  const NoiseLevel few = noise_level(campaign);
  CHECK(few.sigma.xy_mm == 0.010);
  CHECK_THAT(few.words, Contains("too few to decide"));
}

TEST_CASE("one bad repeat does not make the noise: its group is left out", "[measure]") {
  Campaign campaign;
  campaign.machine.measured = {true, true, true};
  campaign.tracker = TrackerSigma{0.010, rad_from_deg(0.004)};
  campaign.readings = repeats(20, 3, 0.010, rad_from_deg(0.004));
  campaign.readings[7].measured->x_mm += 1.0;
  const NoiseLevel level = noise_level(campaign);
  CHECK(level.source == NoiseLevel::Source::tracker);
  CHECK(level.repeats->groups_left_out == 1);
}

TEST_CASE("without a statement the repeats, and with neither it is refused", "[measure]") {
  Campaign campaign;
  campaign.machine.measured = {true, true, true};
  campaign.readings = repeats(10, 3, 0.02, 1e-4);
  CHECK(noise_level(campaign).source == NoiseLevel::Source::repeats);
  campaign.tracker = TrackerSigma{0.010, 0};
  CHECK_THROWS_WITH(noise_level(campaign), Contains("sigma_phi_deg"));
  campaign.tracker.reset();
  campaign.readings = repeats(10, 1, 0.02, 1e-4);
  CHECK_THROWS_WITH(noise_level(campaign), Contains("no pose measured twice"));
}
