#include "core/diagnose/selection.hpp"

#include <algorithm>

#include "core/diagnose/average.hpp"
#include "core/diagnose/diagnose.hpp"

#include "tests/core/diagnose/space.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

Library library_of(const HiddenCase& hidden) { return make_library(space_of(hidden.campaign)); }

/// Parameters of each unit of an effect.
std::vector<std::size_t> unit_sizes(const Library& library, const std::string& effect) {
  std::vector<std::size_t> sizes;
  for (const Unit& u : library.units) {
    if (effect_catalogue()[static_cast<std::size_t>(u.effect)].name == effect) {
      sizes.push_back(u.parameters.size());
    }
  }
  return sizes;
}

}  // namespace

TEST_CASE("a wave's sine and cosine enter as one, a force's components too, rails one by one",
          "[diagnose]") {
  const Library library = library_of(hide({}, 0, 51));
  CHECK(unit_sizes(library, "screw_periodic") == std::vector<std::size_t>{2, 2, 2});
  CHECK(unit_sizes(library, "backlash") == std::vector<std::size_t>{1, 1, 1, 3});  // and on all
  CHECK(unit_sizes(library, "platform_load") == std::vector<std::size_t>{2, 1});
}

TEST_CASE("a set scores its fall of chi^2 less the price of its names and units", "[diagnose]") {
  const Library library = library_of(hide({"backlash"}, 28, 52));
  const auto all = search(library, 2);
  REQUIRE_FALSE(all.empty());
  const Candidate& best = all.front();
  CHECK(names_of(best) == std::vector<std::string>{"backlash"});
  CHECK_THAT(best.gain, WithinRel(gain_of(library, best.units), 1e-9));
  CHECK(best.score <= best.gain - kPriceOfName - kPriceOfParameter);
  // a name that does not earn its price never stands above the set without it
  for (const Candidate& c : all) CHECK(c.score <= best.score);
}

TEST_CASE("a unit that may stand for one that was chosen is fitted too", "[diagnose]") {
  const Library library = library_of(hide({"backlash"}, 28, 53));
  const Candidate best = search(library, 1).front();
  const Candidate fitted = with_all_rails(library, best);
  CHECK(fitted.effects == best.effects);
  CHECK(std::includes(fitted.units.begin(), fitted.units.end(), best.units.begin(),
                      best.units.end()));
  CHECK(fitted.gain >= best.gain - 1e-9);
}

TEST_CASE("an imitation that leaves a thousandth of a large effect is no tie", "[diagnose]") {
  const auto tied = [](double rho) {
    const Library library = library_of(hide({"lead_scale"}, rho, 54));
    const auto all = search(library, 1);
    const auto truth = std::find_if(all.begin(), all.end(), [](const Candidate& c) {
      return names_of(c) == std::vector<std::string>{"lead_scale"};
    });
    REQUIRE(truth != all.end());
    return structural_ties(library, *truth).size();
  };
  CHECK(tied(5) > 0);  // while it is small other effects look the same
  CHECK(tied(200) == 0);
}

TEST_CASE("one lead error on all rails is one parameter, and a range is no cliff", "[diagnose]") {
  const Library library = library_of(hide({"tracker_scale"}, 20, 55));
  const auto all = search(library, 1);
  REQUIRE_FALSE(all.empty());
  const auto score_of = [&](const std::string& name) {
    const auto at = std::find_if(all.begin(), all.end(), [&](const Candidate& c) {
      return names_of(c) == std::vector<std::string>{name};
    });
    REQUIRE(at != all.end());
    return at->score;
  };
  // the same data with as many parameters: what is left is what the tracker's range costs
  CHECK(score_of("lead_scale") - score_of("tracker_scale") > 0);
  CHECK(score_of("lead_scale") - score_of("tracker_scale") < 20);
  CHECK(score_of("lead_scale") > score_of("platform_load"));
}

TEST_CASE("an average over sets holds what is sure, and doubts what is not", "[diagnose]") {
  const auto probability = [](double rho, double Candidate::*weight = &Candidate::weight) {
    const Library library = library_of(hide({"lead_curvature"}, rho, 56));
    const auto all = search(library, 2);
    const Average mean = average(library, family_of(library, all.front(), all), weight);
    for (std::size_t e = 0; e < effect_catalogue().size(); ++e) {
      if (effect_catalogue()[e].name == "lead_curvature") return mean.probability[e];
    }
    return 0.0;
  };
  CHECK(probability(28) > kSure);
  CHECK(probability(4) < kSure);
  CHECK(probability(28, &Candidate::open_weight) >
        kSure);  // what is told apart is sure under any prior
}
