// The gap on unseen readings, for every kind of answer: it shrinks where a name was given, and a
// model that was given none is left alone.

#include <cmath>

#include "core/diagnose/diagnose.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

Diagnosis diagnosed(const HiddenCase& c) { return diagnose(c.campaign, {.replicates = 500}); }

/// 96 unseen readings, x and y: their rms is known to 5 %; 15 % is three standard deviations.
constexpr double kAtTheFloor = 1.15;

}  // namespace

TEST_CASE("nothing missing: on unseen readings the geometry alone leaves the noise", "[diagnose]") {
  const Diagnosis d = diagnosed(hide({}, 0, 7));
  CHECK(d.verdict == Verdict::nothing_missing);
  REQUIRE(d.gap.size() == 2);
  CHECK(*d.gap.back().validate_rms_mm < kAtTheFloor * d.noise.used.xy_mm);
  CHECK(d.next.points.empty());
}

TEST_CASE("ambiguous: what was named closes the gap, whichever of the tied names is true",
          "[diagnose]") {
  const Diagnosis d = diagnosed(hide({"tracker_scale"}, 9, 17));
  CHECK(d.verdict == Verdict::ambiguous);
  REQUIRE(d.gap.size() >= 3);
  CHECK(*d.gap.back().validate_rms_mm < kAtTheFloor * d.noise.used.xy_mm);
  CHECK(*d.gap.back().validate_rms_mm < *d.gap[1].validate_rms_mm);
}

TEST_CASE("unexplained: the model stays the geometry, with its gap open", "[diagnose]") {
  for (const char* name : {"setup_shift", "cubic_lead", "half_turn"}) {
    CAPTURE(name);
    const Diagnosis d = diagnosed(hide({name}, 28, 11));
    CHECK(d.verdict == Verdict::unexplained);
    REQUIRE(d.gap.size() == 2);
    CHECK(*d.gap.back().validate_rms_mm > 1.05 * d.noise.used.xy_mm);
    CHECK(d.fit.model.effects.empty());
  }
}

TEST_CASE("wrong readings beside an effect: both are named, and the gap closes", "[diagnose]") {
  HiddenCase c = hide({"backlash"}, 28, 19);
  const std::vector<int> wrong = {12, 150, 201};
  for (const int seq : wrong) {
    c.campaign.readings[static_cast<std::size_t>(seq - 1)].measured->y_mm -= 0.3;
  }
  const Diagnosis d = diagnosed(c);
  CHECK(d.verdict == Verdict::explained);
  REQUIRE(d.effects.size() == 2);
  CHECK(d.effects[0].name == "outlier_readings");
  CHECK(d.effects[0].seqs == wrong);
  CHECK(d.effects[1].name == "backlash");
  for (const NamedParameter& p : d.effects[1].parameters) {
    const int rail = p.name.back() - '1';
    CHECK(std::abs(p.value - c.truth.drive.backlash_mm[rail]) < 3 * p.std);
  }
  CHECK(*d.gap.back().validate_rms_mm < kAtTheFloor * d.noise.used.xy_mm);
}

TEST_CASE("every step on the way has standard deviations of its own", "[diagnose]") {
  const Diagnosis d = diagnosed(hide({"backlash", "guide_bow"}, 24, 5));
  REQUIRE(d.gap.size() == 4);
  CHECK(d.gap[0].parameters.empty());
  for (std::size_t k = 1; k < d.gap.size(); ++k) {
    const GapStep& step = d.gap[k];
    REQUIRE(step.std.size() == step.parameters.size());
    CHECK(std::any_of(step.std.begin(), step.std.end(), [](const auto& s) { return s && *s > 0; }));
  }
  // the geometry is known less well once an effect is fitted beside it
  CHECK(*d.gap[3].std[0] >= *d.gap[1].std[0]);
}
