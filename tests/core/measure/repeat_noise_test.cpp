#include "core/measure/noise.hpp"

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// `places` commands, each read `times` times about a pose of its own.
std::vector<Reading> repeats(int places, int times, double xy_mm, double phi_rad) {
  Random random(51);
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

TEST_CASE("the tracker's word comes first, repeats second, and with neither it is refused",
          "[measure]") {
  Campaign campaign;
  campaign.readings = repeats(10, 3, 0.02, 1e-4);
  CHECK(noise_level(campaign).source == NoiseLevel::Source::repeats);
  campaign.tracker = TrackerSigma{0.010, rad_from_deg(0.004)};
  CHECK(noise_level(campaign).source == NoiseLevel::Source::tracker);
  CHECK(noise_level(campaign).sigma.xy_mm == 0.010);
  campaign.tracker = TrackerSigma{0.010, 0};
  CHECK_THROWS_WITH(noise_level(campaign), Contains("sigma_phi_deg"));
  campaign.tracker.reset();
  campaign.readings = repeats(10, 1, 0.02, 1e-4);
  CHECK_THROWS_WITH(noise_level(campaign), Contains("no pose measured twice"));
}
