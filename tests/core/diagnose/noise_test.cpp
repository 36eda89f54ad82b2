#include "core/diagnose/noise.hpp"

#include <cmath>

#include "core/diagnose/selection.hpp"
#include "tests/core/diagnose/space.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

TEST_CASE("the noise ratio is the true sigma over the stated one, effects or not", "[diagnose]") {
  for (const bool with_effect : {false, true}) {
    const std::vector<const Family*> hidden = with_effect
                                                  ? std::vector<const Family*>{&family("backlash")}
                                                  : std::vector<const Family*>{};
    const ResidualSpace space =
        space_of(make_case({.stated_over_true = 0.8}, hidden, 20, 1).campaign);
    const NoiseRatio ratio = noise_ratio(space, make_library(space).signals);
    // 4 standard uncertainties, ratio / sqrt(2 dof): 1 in 16 000
    CHECK(std::abs(ratio.xy - 1.25) < 4 * ratio.xy / std::sqrt(2 * ratio.xy_dof));
    CHECK(std::abs(ratio.phi - 1.25) < 4 * ratio.phi / std::sqrt(2 * ratio.phi_dof));
    CHECK(ratio.xy_dof > 400);
    CHECK(other_size(ratio.xy, ratio.xy_dof));
  }
}

TEST_CASE("a reading six sigmas off is bad, one three sigmas off is not", "[diagnose]") {
  HiddenCase c = make_case({}, {}, 0, 2);
  c.campaign.readings[30].measured->y_mm += 0.08;
  c.campaign.readings[60].measured->y_mm += 0.02;
  const ResidualSpace space = space_of(c.campaign);
  const auto bad = bad_readings(space, make_library(space).signals);
  REQUIRE(bad.size() == 1);
  CHECK(space.readings[bad[0]].seq == 31);
}

TEST_CASE("clean campaigns have bad readings as rarely as stated", "[diagnose]") {
  int with_bad = 0;
  for (std::uint64_t seed = 100; seed < 140; ++seed) {
    const ResidualSpace space = space_of(make_case({.thinning = 0.5}, {}, 0, seed).campaign);
    with_bad += !bad_readings(space, make_library(space).signals).empty();
  }
  CHECK(with_bad <= 1);  // 40 campaigns at 0.05 %: two or more in 0.02 % of runs
}

TEST_CASE("many wrong readings are structure, not single bad readings", "[diagnose]") {
  HiddenCase c = make_case({}, {}, 0, 3);
  for (std::size_t i = 0; i < 70; ++i) c.campaign.readings[3 * i].measured->x_mm += 0.2;
  const ResidualSpace space = space_of(c.campaign);
  CHECK(bad_readings(space, make_library(space).signals).empty());
}

TEST_CASE("a run of wrong readings is a course in time, not single bad readings", "[diagnose]") {
  HiddenCase c = make_case({}, {}, 0, 4);
  for (std::size_t i = 60; i < 72; ++i) c.campaign.readings[i].measured->x_mm += 0.1;
  const ResidualSpace space = space_of(c.campaign);
  CHECK(bad_readings(space, make_library(space).signals).empty());
  for (std::size_t i = 60; i < 72; ++i) c.campaign.readings[i].measured->x_mm -= 0.1;
  c.campaign.readings[60].measured->x_mm += 0.1;  // alone it is one
  const ResidualSpace alone = space_of(c.campaign);
  CHECK(bad_readings(alone, make_library(alone).signals) == std::vector<std::size_t>{60});
}

TEST_CASE("on few degrees of freedom chance makes a sigma look small, and it is not shrunk",
          "[diagnose]") {
  CHECK_FALSE(other_size(0.4, 4));  // chi^2(4) is below 0.64 in 4 % of campaigns
  CHECK_FALSE(other_size(2.1, 4));  // and above 17.6 in 0.15 %
  CHECK(other_size(0.4, 100));
  CHECK(other_size(1.3, 500));
  CHECK_FALSE(other_size(1.05, 500));
}

TEST_CASE("noise of heavy tails is told from single bad readings and from normal noise",
          "[diagnose]") {
  HiddenCase c = make_case({}, {}, 0, 5);
  const auto tails_of = [](const Campaign& campaign) {
    const ResidualSpace space = space_of(campaign);
    return heavy_tails(space, make_library(space).signals);
  };
  CHECK_FALSE(tails_of(c.campaign));
  Campaign four = c.campaign;
  for (const std::size_t i : {12U, 77U, 150U, 201U}) four.readings[i].measured->x_mm += 0.3;
  CHECK_FALSE(tails_of(four));
  const auto tails = tails_of(hide({}, 0, 5, {.student = 3}).campaign);
  REQUIRE(tails);
  CHECK_FALSE(tails->far.empty());
  CHECK(tails->gross.empty());
}
