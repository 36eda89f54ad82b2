// Errors outside the catalogue that come close to an effect in it. Seeds are fixed; the study of
// core/diagnose/README.md counts how often a name is wrong.

#include "core/diagnose/look_alikes.hpp"

#include <algorithm>
#include <cmath>

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
    const Diagnosis d = diagnose(late.campaign);
    for (const NamedEffect& e : d.effects) {
      CHECK((e.name != "thermal_growth" || d.verdict == Verdict::ambiguous));
    }
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

TEST_CASE("what remembers the path or the temperature is named, with its length or time",
          "[diagnose]") {
  for (const char* name : {"hysteresis", "move_memory", "lagged_growth"}) {
    for (const std::uint64_t seed : {46u, 47u, 48u}) {
      CAPTURE(name, seed);
      const HiddenCase c = hide({name}, 28, seed);
      const Diagnosis d = diagnose(c.campaign);
      REQUIRE(d.verdict == Verdict::explained);
      REQUIRE(d.effects.size() == 1);
      CHECK(d.effects.front().name == name);
      const auto hidden = parameters_of(c);
      for (const NamedParameter& p : d.effects.front().parameters) {
        const auto at = hidden.find(std::string(name) + " " + p.name);
        if (at == hidden.end()) continue;  // a choice of radii
        CAPTURE(p.name, p.value, p.std, at->second);
        CHECK(std::abs(p.value - at->second) < 4 * p.std);
      }
    }
  }
}

TEST_CASE("growth whose lag hardly shows is a tie with growth that does not lag", "[diagnose]") {
  int doubted = 0;
  for (const std::uint64_t seed : {61u, 62u, 63u, 64u}) {
    CAPTURE(seed);
    const Diagnosis d = diagnose(hide({"lagged_growth"}, 9, seed).campaign);
    const bool prompt = d.effects.size() == 1 && d.effects.front().name == "thermal_growth";
    CHECK_FALSE((prompt && d.verdict == Verdict::explained));
    doubted += d.verdict == Verdict::ambiguous;
  }
  CHECK(doubted > 0);  // control: not silent throughout
}

TEST_CASE("a thermometer that stands still shows no growth that lags", "[diagnose]") {
  const auto offered = [](bool still) {
    HiddenCase c = hide({"lagged_growth"}, 28, 65);
    for (Reading& r : c.campaign.readings)
      if (still) r.conditions.temp_degc = 23.5;
    const Diagnosis d = diagnose(c.campaign);
    const auto is_lag = [](const auto& e) { return e.name == "lagged_growth"; };
    return std::ranges::any_of(d.effects, is_lag) || std::ranges::any_of(d.may_also_hold, is_lag);
  };
  CHECK_FALSE(offered(true));
  CHECK(offered(false));  // control
}

TEST_CASE("backlash and growth that remember nothing keep their names", "[diagnose]") {
  for (const char* name : {"backlash", "thermal_growth"}) {
    const Diagnosis d = diagnose(hide({name}, 28, 46).campaign);
    REQUIRE(d.effects.size() == 1);
    CHECK(d.effects.front().name == name);
  }
}

TEST_CASE("where all approaches have one length backlash and memory are not told apart",
          "[diagnose]") {
  HiddenCase c = hide({"move_memory"}, 28, 47);
  // the same data with one length: what is remembered is then the same at each reading
  for (Reading& r : c.campaign.readings) {
    for (int k = 0; k < 3; ++k) {
      const double sign = r.conditions.cmd_mm[k] > r.conditions.from_mm[k] ? 1 : -1;
      r.conditions.from_mm[k] = r.conditions.cmd_mm[k] - 5 * sign;
    }
  }
  const Diagnosis d = diagnose(c.campaign);
  for (const NamedEffect& e : d.effects) CHECK(e.name != "move_memory");
  CHECK(std::ranges::any_of(d.notes, [](const std::string& note) {
    return note.find("all approaches have one length") != std::string::npos;
  }));
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
