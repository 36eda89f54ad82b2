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
  std::vector<LookAlike> alike;
};

Taken taken(const HiddenCase& hidden) {
  const ResidualSpace space = space_of(hidden.campaign);
  const Library library = make_library(space);
  const auto all = search(library, 1);
  REQUIRE_FALSE(all.empty());
  return {all.front(), look_alikes(space, library, all.front(),
                                   History(hidden.campaign.machine, hidden.campaign.readings))};
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
  const auto motion = std::find_if(lost.alike.begin(), lost.alike.end(), [](const LookAlike& a) {
    return a.name.find("lose motion") != std::string::npos;
  });
  REQUIRE(motion != lost.alike.end());
  CHECK(motion->evidence > kEvidence20To1);
  const Taken real = taken(hide({"backlash"}, 28, 44));
  REQUIRE(names_of(real.best) == std::vector<std::string>{"backlash"});
  CHECK(real.alike.empty());
}

TEST_CASE("friction that remembers the path is not called backlash", "[diagnose]") {
  for (const char* name : {"hysteresis", "move_memory"}) {
    for (const std::uint64_t seed : {46u, 47u, 48u}) {
      CAPTURE(name, seed);
      CHECK(diagnose(hide({name}, 28, seed).campaign).verdict != Verdict::explained);
    }
  }
}

TEST_CASE("a tilted measuring plane is a rival of the scale it looks like", "[diagnose]") {
  const Diagnosis d = diagnose(hide({"plane_tilt"}, 14, 49).campaign);
  CHECK(d.verdict != Verdict::explained);
  CHECK(std::ranges::any_of(
      d.rivals, [](const Rival& r) { return r.names == std::vector<std::string>{"plane_tilt"}; }));
}

TEST_CASE("an effect without look-alikes is asked nothing", "[diagnose]") {
  CHECK(taken(hide({"guide_bow"}, 28, 45)).alike.empty());
}
