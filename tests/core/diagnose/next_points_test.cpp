#include "core/diagnose/next_points.hpp"

#include <algorithm>

#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

int place(const std::string& effect) {
  const auto all = effect_catalogue();
  return static_cast<int>(
      std::find_if(all.begin(), all.end(), [&](const Effect& e) { return e.name == effect; }) -
      all.begin());
}

struct Measured {
  std::vector<Reading> readings;
  GeometryFit fit;
  TrackerSigma sigma;
};

Measured one_direction() {
  HiddenCase c = make_case({.name = "paper"}, {}, 0, 1);
  Measured m;
  m.sigma = *c.campaign.tracker;
  for (Reading r : c.campaign.readings) {
    if (r.set != ReadingSet::identify) continue;
    r.conditions.from_mm = r.conditions.cmd_mm - Displacements::Constant(5);
    m.readings.push_back(r);
  }
  m.fit = fit_geometry(nominal_model(c.campaign.mechanism), m.readings, m.sigma);
  return m;
}

}  // namespace

TEST_CASE("backlash that one direction hides is made visible by points from both sides",
          "[diagnose]") {
  const Measured m = one_direction();
  std::vector<Tie> ties;
  for (int rail = 0; rail < 3; ++rail) {
    Tie tie;
    tie.signal = {{place("backlash"), rail, 0.03}};
    tie.why = "makes backlash visible";
    ties.push_back(tie);
  }
  const NextPoints next = plan_next_points(m.fit, m.readings, m.sigma, ties);
  CHECK(next.energy_before < 1e-3);
  CHECK(next.energy_after > 25);  // 0.03 mm on any rail stands out by five sigmas
  CHECK(next.undecided.empty());
  for (std::size_t rail = 0; rail < 3; ++rail) {
    CHECK(std::any_of(next.points.begin(), next.points.end(),
                      [&](const NextPoint& p) { return p.approach[rail] > 0; }));
    CHECK(std::any_of(next.points.begin(), next.points.end(),
                      [&](const NextPoint& p) { return p.approach[rail] < 0; }));
  }
}

TEST_CASE("a tie that no pose can break is said to be one, and no points are wasted on it",
          "[diagnose]") {
  const Measured m = one_direction();
  Tie tie{{{place("tracker_scale"), 0, 1e-4}}, {}, "tells tracker_scale from lead_scale"};
  for (int rail = 0; rail < 3; ++rail) tie.columns.push_back({place("lead_scale"), rail, 0});
  const NextPoints next = plan_next_points(m.fit, m.readings, m.sigma, {tie});
  CHECK(next.energy_after < 1);
  CHECK(next.undecided == std::vector<std::string>{"tells tracker_scale from lead_scale"});
  CHECK(next.points.empty());
}

TEST_CASE("without a tie nothing is planned", "[diagnose]") {
  const Measured m = one_direction();
  CHECK(plan_next_points(m.fit, m.readings, m.sigma, {}).points.empty());
}
