#include "core/diagnose/next_points.hpp"

#include <algorithm>
#include <set>
#include <tuple>

#include "core/diagnose/diagnose.hpp"
#include "core/diagnose/ties.hpp"
#include "core/plane/extent.hpp"
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

/// The paper's 80 points, each rail arriving from below, at one temperature.
Measured one_direction(double temp_degc = 23) {
  HiddenCase c = make_case({.name = "paper"}, {}, 0, 1);
  Measured m;
  m.sigma = *c.campaign.tracker;
  for (Reading r : c.campaign.readings) {
    if (r.set != ReadingSet::identify) continue;
    r.conditions.from_mm = r.conditions.cmd_mm - Displacements::Constant(5);
    r.conditions.temp_degc = temp_degc;
    m.readings.push_back(r);
  }
  m.fit = fit_geometry(nominal_model(mechanism_of(c.campaign.machine)), m.readings, m.sigma);
  return m;
}

std::vector<Tie> hidden_backlash(double size_mm) {
  std::vector<Tie> ties;
  for (int rail = 0; rail < 3; ++rail) {
    Tie tie;
    tie.signal = {effect_term(place("backlash"), rail, size_mm)};
    tie.effects = {place("backlash")};
    tie.by_direction = true;
    tie.why = "makes backlash visible";
    ties.push_back(tie);
  }
  return ties;
}

Tie against(const std::string& named, double value, const std::string& rival) {
  Tie tie;
  for (int rail = 0; rail < 3; ++rail) {
    if (named != "tracker_scale" || rail == 0) {
      tie.signal.push_back(effect_term(place(named), rail, value));
    }
    tie.columns.push_back(effect_term(place(rival), rail, 1e-3));
  }
  tie.effects = {place(named), place(rival)};
  tie.why = "tells " + named + " from " + rival;
  tie.instead = "another instrument";
  return tie;
}

}  // namespace

TEST_CASE("backlash that one direction hides is made visible by points from both sides",
          "[diagnose]") {
  const Measured m = one_direction();
  const NextPoints next = plan_next_points(m.fit, m.readings, m.sigma, hidden_backlash(0.03));
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

TEST_CASE("no point is suggested twice, and a smaller effect takes more points", "[diagnose]") {
  const Measured m = one_direction();
  std::size_t before = 0;
  for (const double size_mm : {0.06, 0.015}) {
    const NextPoints next = plan_next_points(m.fit, m.readings, m.sigma, hidden_backlash(size_mm));
    std::set<std::tuple<double, double, double, std::array<int, 3>>> different;
    for (const NextPoint& p : next.points) {
      different.emplace(p.target.x_mm, p.target.y_mm, p.target.phi_rad, p.approach);
    }
    CHECK(different.size() == next.points.size());
    CHECK(next.points.size() > before);
    CHECK(next.points.size() <= static_cast<std::size_t>(NextOptions{}.most));
    before = next.points.size();
  }
}

TEST_CASE("a tie that no pose can break is said to be one, with the measurement that would",
          "[diagnose]") {
  const Measured m = one_direction();
  const NextPoints next =
      plan_next_points(m.fit, m.readings, m.sigma, {against("tracker_scale", 1e-4, "lead_scale")});
  CHECK(next.energy_after < 1);
  REQUIRE(next.undecided.size() == 1);
  CHECK(next.undecided[0].what == "tells tracker_scale from lead_scale");
  CHECK(next.undecided[0].instead == "another instrument");
  CHECK(next.points.empty());
}

TEST_CASE("what one temperature ties, points at another temperature decide", "[diagnose]") {
  const Measured m = one_direction(23);
  const Tie tie = against("thermal_growth", 5e-5, "lead_scale");
  const NextPoints next = plan_next_points(m.fit, m.readings, m.sigma, {tie});
  CHECK(next.energy_before < 1e-3);
  CHECK(next.energy_after > energy_needed(0));
  CHECK(next.state.temp_degc == 28);
  CHECK(next.undecided.empty());
}

TEST_CASE("a rival without a name gets points like any other", "[diagnose]") {
  // A period 2 % off the lead: over the 80 points nearly the same wave.
  const Measured m = one_direction();
  Tie tie;
  tie.signal = {effect_term(place("screw_periodic"), 0, 0.02)};
  for (const bool sine : {true, false}) {
    tie.columns.push_back({[sine](const Reading&, const Moment& moment) {
      const double turn = 2 * 3.14159265358979 * moment.l_mm[0] / 10.2;
      Deviation d;
      d.dl_mm[0] = sine ? std::sin(turn) : std::cos(turn);
      return d;
    }});
  }
  tie.why = "tells screw_periodic from an unnamed error";
  const NextPoints next = plan_next_points(m.fit, m.readings, m.sigma, {tie});
  CHECK(next.energy_after > next.energy_before + energy_needed(0));
  REQUIRE_FALSE(next.points.empty());
  CHECK(next.points.front().why == tie.why);
}

TEST_CASE("backlash and a memory of moves of one length are told apart by moves of another",
          "[diagnose]") {
  Measured m = one_direction();
  int i = 0;
  for (Reading& r : m.readings) {
    const double from = ++i % 2 == 0 ? 5 : -5;
    r.conditions.from_mm = r.conditions.cmd_mm + Displacements::Constant(from);
  }
  Tie tie = hidden_backlash(0.05).front();
  tie.columns.push_back({[](const Reading&, const Moment& at) {
    Deviation d;
    d.dl_mm[0] = -at.direction[0] * std::exp(-std::abs(at.travel_mm[0]) / 5);
    return d;
  }});
  SECTION("of the usual length no point can") {
    const NextPoints next = plan_next_points(m.fit, m.readings, m.sigma, {tie});
    CHECK(next.points.empty());
    CHECK(next.undecided.size() == 1);
  }
  SECTION("of another length they do") {
    tie.by_length = true;
    const NextPoints next = plan_next_points(m.fit, m.readings, m.sigma, {tie});
    CHECK(next.energy_before < 1e-3);
    CHECK(next.energy_after > energy_needed(0));
    CHECK(next.state.approach_mm != 5);
    CHECK(next.undecided.empty());
  }
}

TEST_CASE("the energy asked of new points is what the lead leaves to do", "[diagnose]") {
  CHECK_THAT(energy_needed(0), WithinAbs(47.2, 0.1));   // (3 + sqrt(15))^2
  CHECK_THAT(energy_needed(6), WithinAbs(36.0, 1e-9));  // at 20:1 already: (3 + 3)^2
  CHECK(energy_needed(3) < energy_needed(0));
}

TEST_CASE("points are asked for where it was measured, or where the bounds allow", "[diagnose]") {
  Measured m = one_direction();
  std::erase_if(m.readings, [](const Reading& r) {
    return std::abs(r.target.x_mm) > 60 || r.target.y_mm > 40;
  });
  const auto ties = hidden_backlash(0.03);
  const NextPoints inside_hull = plan_next_points(m.fit, m.readings, m.sigma, ties);
  REQUIRE_FALSE(inside_hull.points.empty());
  for (const NextPoint& p : inside_hull.points) {
    CHECK(std::abs(p.target.x_mm) <= 60);
    CHECK(p.target.y_mm <= 40);
  }
  const NextPoints asked =
      plan_next_points(m.fit, m.readings, m.sigma, ties, {.within = square_hull(-30, 20)});
  REQUIRE_FALSE(asked.points.empty());
  for (const NextPoint& p : asked.points) {
    for (const double at_mm : {p.target.x_mm, p.target.y_mm}) {
      CHECK(at_mm >= -30);
      CHECK(at_mm <= 20);
    }
  }
}

TEST_CASE("without a tie nothing is planned", "[diagnose]") {
  const Measured m = one_direction();
  CHECK(plan_next_points(m.fit, m.readings, m.sigma, {}).points.empty());
}

TEST_CASE("what is explained still plans for effects of usual size that would not have been seen",
          "[diagnose]") {
  // At one orientation, with a coarse attitude, a load on the platform hardly shows.
  const Diagnosis paper =
      diagnose(hide({"backlash"}, 28, 3, {.name = "paper", .sigma_phi_deg = 0.055}).campaign);
  REQUIRE(paper.verdict == Verdict::explained);
  std::set<std::string> whys;
  for (const NextPoint& p : paper.next.points) whys.insert(p.why);
  CHECK(whys.count("makes platform_load visible") == 1);
  CHECK(whys.count("makes backlash visible") == 0);
  for (const AuditRow& row : paper.audit) {
    if (whys.count("makes " + row.effect + " visible") > 0) CHECK(row.only_unusual());
  }
  // A rich plan would have shown them all: nothing is asked for.
  const Diagnosis rich = diagnose(hide({"backlash"}, 28, 3).campaign);
  REQUIRE(rich.verdict == Verdict::explained);
  CHECK(rich.next.points.empty());
}
