// The workflow on machines that are no 3-PRR. What is hidden is written out here as an axis errs,
// apart from the effects' own code. Seeds are fixed; a wrong name or a false alarm is expected in
// at most 1 of 100 such cases (core/diagnose/README.md).

#include <cmath>
#include <functional>

#include "core/diagnose/by_target.hpp"
#include "core/diagnose/diagnose.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

constexpr double kSigmaMm = 0.001;

/// Where an axis or a stage stands: commanded place and direction of approach.
struct Stand {
  double x = 0, y = 0, dir_x = 0, dir_y = 0;
  int run = 0, target = 0;
};
using Errs = std::function<Eigen::Vector2d(const Stand&)>;

Reading reading_at(const Stand& s, double length_mm, bool both) {
  Reading r;
  r.target = {s.x, both ? s.y : 0, 0};
  r.conditions.cmd_mm = {s.x, both ? s.y : 0, 0};
  r.conditions.from_mm = r.conditions.cmd_mm;
  r.conditions.from_mm[0] -= s.dir_x * length_mm;
  if (both) r.conditions.from_mm[1] -= s.dir_y * length_mm;
  return r;
}

/// 9 x 9 nodes of an XY stage, every fourth for validation; sigma of y is `y_over_x` of that of x.
Campaign stage(std::uint64_t seed, const Errs& errs, double y_over_x = 1) {
  Campaign c;
  c.name = "stage";
  c.machine = starting_machine("XY");
  c.tracker = TrackerSigma{kSigmaMm, 0};
  Random random(seed);
  for (int i = -4; i <= 4; ++i) {
    for (int j = -4; j <= 4; ++j) {
      const Stand s{30.0 * i, 30.0 * j, random.below(2) == 0 ? 1.0 : -1.0,
                    random.below(2) == 0 ? 1.0 : -1.0};
      Reading r = reading_at(s, random.uniform(3, 20), true);
      r.seq = static_cast<int>(c.readings.size()) + 1;
      if (r.seq % 4 == 0) r.set = ReadingSet::validate;
      // zeros, the turn of the frame and 20 arc seconds of squareness: geometry
      const Eigen::Vector2d d = errs(s) + Eigen::Vector2d(0.05 + 2e-4 * s.y, -0.03 - 3e-4 * s.x);
      r.measured = Pose{s.x + d[0] + kSigmaMm * random.normal(),
                        s.y + d[1] + y_over_x * kSigmaMm * random.normal(), 0};
      c.readings.push_back(r);
    }
  }
  return c;
}

/// Runs of an axis over 11 targets, both ways.
Campaign axis(std::uint64_t seed, const Errs& errs, int targets = 11, int runs = 5) {
  Campaign c;
  c.name = "axis";
  c.machine = starting_machine("X");
  c.tracker = TrackerSigma{kSigmaMm, 0};
  Random random(seed);
  for (int k = 0; k < targets; ++k) {
    for (int run = 0; run < runs; ++run) {
      for (const double dir : {1.0, -1.0}) {
        const Stand s{.x = -120 + 240.0 * k / (targets - 1), .dir_x = dir, .run = run, .target = k};
        Reading r = reading_at(s, random.uniform(3, 20), false);
        r.seq = static_cast<int>(c.readings.size()) + 1;
        r.measured = Pose{s.x + 0.02 + errs(s)[0] + kSigmaMm * random.normal(), 0, 0};
        c.readings.push_back(r);
      }
    }
  }
  return c;
}

std::vector<std::string> names_of_effects(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const NamedEffect& e : d.effects) names.push_back(e.name);
  return names;
}

Eigen::Vector2d nothing(const Stand&) { return {0, 0}; }

}  // namespace

TEST_CASE(
    "effects of an XY stage are named by axis, with their size, and close the gap on unseen "
    "nodes",
    "[diagnose]") {
  struct Case {
    std::string name;
    Errs errs;
    int rail;
    double value;
  };
  const std::vector<Case> cases = {
      {"lead_scale", [](const Stand& s) { return Eigen::Vector2d(1e-3 * s.x, 0); }, 1, 1e-3},
      {"lead_curvature", [](const Stand& s) { return Eigen::Vector2d(0, 2e-6 * s.y * s.y); }, 2,
       2e-6},
      {"guide_bow", [](const Stand& s) { return Eigen::Vector2d(0, 2e-6 * s.x * s.x); }, 2, 2e-6},
      {"guide_yaw", [](const Stand& s) { return Eigen::Vector2d(-1e-6 * s.x * s.y, 0); }, 1,
       deg_from_rad(1e-6)},
      {"backlash", [](const Stand& s) { return Eigen::Vector2d(0, -0.006 * s.dir_y); }, 2, 0.012}};
  for (const Case& c : cases) {
    INFO(c.name);
    const Diagnosis d = diagnose(stage(3, c.errs));
    CHECK(d.verdict == Verdict::explained);
    REQUIRE(names_of_effects(d) == std::vector<std::string>{c.name});
    CHECK(d.effects[0].rails == std::vector<int>{c.rail});
    const NamedParameter& p = d.effects[0].parameters[0];
    INFO(p.name << " = " << p.value << " +- " << p.std);
    CHECK(std::abs(p.value - c.value) < 3 * p.std);
    CHECK(*d.gap.back().validate_rms_mm < 1.25 * kSigmaMm);  // 4 sigmas of 40 coordinates
    CHECK(*d.gap.back().closed_share > 0.95);
  }
}

TEST_CASE("on clean readings of a stage and of an axis nothing is missing", "[diagnose]") {
  // false alarms: 0.7 % of cases; fixed seeds
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    INFO(seed);
    CHECK(diagnose(stage(seed, nothing)).verdict == Verdict::nothing_missing);
    CHECK(diagnose(axis(seed, nothing)).verdict == Verdict::nothing_missing);
  }
}

TEST_CASE("two axes have a noise each, and a small error of the better one is seen", "[diagnose]") {
  const Diagnosis d = diagnose(stage(
      5, [](const Stand& s) { return Eigen::Vector2d(0, 5e-8 * s.x * s.x); }, 0.1));
  CHECK_THAT(d.noise.y_over_x, WithinAbs(0.1, 0.03));
  CHECK(names_of_effects(d) == std::vector<std::string>{"guide_bow"});
}

TEST_CASE("an axis can't tell its lead from the instrument's scale", "[diagnose]") {
  const Diagnosis d =
      diagnose(axis(6, [](const Stand& s) { return Eigen::Vector2d(8e-5 * s.x, 0); }));
  CHECK(d.verdict == Verdict::ambiguous);
  std::vector<std::string> all = names_of_effects(d);
  for (const Rival& r : d.rivals) all.insert(all.end(), r.names.begin(), r.names.end());
  for (const char* name : {"lead_scale", "tracker_scale"}) {
    CHECK(std::ranges::find(all, name) != all.end());
  }
  const Diagnosis play =
      diagnose(axis(7, [](const Stand& s) { return Eigen::Vector2d(-0.004 * s.dir_x, 0); }));
  CHECK(play.verdict == Verdict::explained);
  CHECK(names_of_effects(play) == std::vector<std::string>{"backlash"});
}

TEST_CASE("a reversal that differs by target and drifts from run to run is no backlash",
          "[diagnose]") {
  const double reversal_mm[] = {0.015, 0.004, 0.009}, drift_mm[] = {-0.002, 0, -0.0014};
  const Campaign c = axis(
      8,
      [&](const Stand& s) {
        const auto k = static_cast<std::size_t>(s.target);
        return Eigen::Vector2d(0.5 * reversal_mm[k] * s.dir_x + drift_mm[k] * s.run, 0);
      },
      3, 10);
  const Diagnosis d = diagnose(c);
  CHECK(d.verdict != Verdict::explained);
  CHECK(d.verdict != Verdict::nothing_missing);
  CHECK(std::ranges::count(names_of_effects(d), "backlash") == 0);
  const auto at = reversals_by_target(c.machine, c.readings);
  REQUIRE(at.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    INFO(in_words(at[k], c.machine));
    CHECK(at[k].readings == 20);
    CHECK(std::abs(at[k].reversal_mm - reversal_mm[k]) < 4 * at[k].reversal_std_mm);
    CHECK(std::abs(at[k].drift_mm - drift_mm[k]) < 4 * at[k].drift_std_mm);
    // of s = 1 um and 20 readings: 2 s / sqrt(20), and s / sqrt(20 * 8.25) over 10 runs
    CHECK_THAT(at[k].reversal_std_mm, WithinAbs(0.00045, 0.0003));
    CHECK_THAT(at[k].drift_std_mm, WithinAbs(0.000078, 0.00005));
  }
}

TEST_CASE("a reversal at one target alone is no noise that alternates, and no explained axis",
          "[diagnose]") {
  const auto errs = [](double reversal_mm) {
    return [=](const Stand& s) {
      return Eigen::Vector2d(
          0.001 * s.x * (s.x + 40) / 120 + (s.target == 1 ? 0.5 * reversal_mm * s.dir_x : 0), 0);
    };
  };
  const Diagnosis d = diagnose(axis(11, errs(0.004), 3, 10));
  CHECK(d.verdict == Verdict::unexplained);
  REQUIRE_FALSE(d.structure.empty());
  CHECK_THAT(d.structure[0].when, Contains("differs from target to target"));
  CHECK_FALSE(d.tried.empty());
  // the control: without the reversal the same axis is not doubted for one
  for (std::uint64_t seed = 12; seed < 16; ++seed) {
    for (const Finding& f : diagnose(axis(seed, errs(0), 3, 10)).structure) {
      CHECK_THAT(f.when, !Contains("reversal"));
    }
  }
}

TEST_CASE("where a stage's answer is open, points are proposed that its axes reach", "[diagnose]") {
  // approaches of one side hide backlash: the audit asks for the other
  Campaign c = stage(9, nothing);
  for (Reading& r : c.readings) r.conditions.from_mm = r.conditions.cmd_mm - Displacements(5, 5, 0);
  const Diagnosis d = diagnose(c);
  REQUIRE_FALSE(d.next.points.empty());
  for (const NextPoint& p : d.next.points) {
    CHECK(reach(c.machine, p.target).ok());
    CHECK(p.target.phi_rad == 0);
    CHECK(p.approach[2] == 0);
  }
}
