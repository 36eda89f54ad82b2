#include "core/diagnose/noise.hpp"

#include "core/diagnose/selection.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

struct Fitted {
  std::vector<Reading> readings;
  ResidualSpace space;
};

Fitted fitted(const Campaign& campaign) {
  Fitted f;
  for (const Reading& r : campaign.readings) {
    if (r.set == ReadingSet::identify) f.readings.push_back(r);
  }
  const GeometryFit fit =
      fit_geometry(nominal_model(campaign.mechanism), f.readings, *campaign.tracker);
  f.space = residual_space(fit, f.readings, *campaign.tracker);
  return f;
}

}  // namespace

TEST_CASE("the noise ratio is the true sigma over the stated one, effects or not", "[diagnose]") {
  for (const bool with_effect : {false, true}) {
    const std::vector<const Family*> hidden = with_effect
                                                  ? std::vector<const Family*>{&family("backlash")}
                                                  : std::vector<const Family*>{};
    const Fitted f = fitted(make_case({.stated_over_true = 0.8}, hidden, 20, 1).campaign);
    const NoiseRatio ratio = noise_ratio(f.space, make_library(f.space).signals);
    // 4 standard uncertainties: 1 in 16 000
    CHECK(std::abs(ratio.xy - 1.25) < 4 * ratio.u_xy);
    CHECK(std::abs(ratio.phi - 1.25) < 4 * ratio.u_phi);
    CHECK(ratio.u_xy < 0.05);
  }
}

TEST_CASE("a reading six sigmas off is bad, one three sigmas off is not", "[diagnose]") {
  HiddenCase c = make_case({}, {}, 0, 2);
  c.campaign.readings[30].measured->y_mm += 0.08;
  c.campaign.readings[60].measured->y_mm += 0.02;
  const Fitted f = fitted(c.campaign);
  const auto bad = bad_readings(f.space, make_library(f.space).signals);
  REQUIRE(bad.size() == 1);
  CHECK(f.readings[bad[0]].seq == 31);
}

TEST_CASE("clean campaigns have bad readings as rarely as stated", "[diagnose]") {
  int with_bad = 0;
  for (std::uint64_t seed = 100; seed < 140; ++seed) {
    const Fitted f = fitted(make_case({.thinning = 0.5}, {}, 0, seed).campaign);
    with_bad += !bad_readings(f.space, make_library(f.space).signals).empty();
  }
  CHECK(with_bad <= 1);  // 40 campaigns at 0.05 %: two or more in 0.02 % of runs
}

TEST_CASE("many wrong readings are structure, not single bad readings", "[diagnose]") {
  HiddenCase c = make_case({}, {}, 0, 3);
  for (std::size_t i = 0; i < 70; ++i) c.campaign.readings[3 * i].measured->x_mm += 0.2;
  const Fitted f = fitted(c.campaign);
  CHECK(bad_readings(f.space, make_library(f.space).signals).empty());
}
