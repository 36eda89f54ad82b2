// Errors outside the catalogue that come close to an effect in it. Seeds are fixed; the study of
// core/diagnose/README.md counts how often a name is wrong.

#include "core/diagnose/look_alikes.hpp"

#include "core/diagnose/diagnose.hpp"
#include "tests/core/diagnose/space.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

/// What the search takes for the cause, and what looks like it.
struct Taken {
  Candidate best;
  std::optional<LookAlike> alike;
};

Taken taken(const HiddenCase& hidden) {
  const ResidualSpace space = space_of(hidden.campaign);
  const Library library = make_library(space);
  const auto all = search(library, 1);
  REQUIRE_FALSE(all.empty());
  return {all.front(), best_look_alike(space, library, all.front())};
}

}  // namespace

TEST_CASE("motion lost in proportion to the move is not called backlash", "[diagnose]") {
  for (const std::uint64_t seed : {41u, 42u, 43u}) {
    CAPTURE(seed);
    const HiddenCase lost = hide({"lost_motion"}, 20, seed);
    CHECK(diagnose(lost.campaign).verdict != Verdict::explained);
  }
}

TEST_CASE("a rail that follows the thermometer late is not called thermal growth", "[diagnose]") {
  for (const std::uint64_t seed : {41u, 42u, 43u}) {
    CAPTURE(seed);
    const HiddenCase late = hide({"thermal_lag"}, 20, seed);
    CHECK(diagnose(late.campaign).verdict != Verdict::explained);
  }
}

TEST_CASE("the look-alike gains over the effect where it is true, and loses where it is not",
          "[diagnose]") {
  const Taken lost = taken(hide({"lost_motion"}, 28, 44));
  REQUIRE(names_of(lost.best) == std::vector<std::string>{"backlash"});
  REQUIRE(lost.alike);
  CHECK(lost.alike->evidence > 12);
  CHECK_THAT(lost.alike->finding.where, Contains("lose motion"));
  const Taken real = taken(hide({"backlash"}, 28, 44));
  REQUIRE(names_of(real.best) == std::vector<std::string>{"backlash"});
  CHECK_FALSE(real.alike);
}

TEST_CASE("an effect without look-alikes is asked nothing", "[diagnose]") {
  CHECK_FALSE(taken(hide({"guide_bow"}, 28, 45)).alike);
}
