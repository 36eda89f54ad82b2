// The screen on campaigns made here: robots of several sizes with errors of geometry up to
// millimetres are sound, and what is done to their columns is named. The long version
// ("[.study]") counts 240 clean and 240 mutated ones: no false alarm, and 232 of 232 named (eight
// have no orientation that could tell radians).

#include "core/measure/screen.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>

#include "core/measure/bad_readings.hpp"
#include "core/measure/gross.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

constexpr std::size_t kPlatformR = 2, kLinkS = 3,
                      kRailR = 5;  // places among the values of a PRR chain

/// A paper's robot some times as large, measured at random poses or on a lattice walked in lines.
Campaign made(std::uint64_t seed) {
  Random random(seed);
  Campaign c;
  c.name = "made";
  c.machine = machine_of(paper_mechanism());
  const double size = random.uniform(0.4, 1.8);
  for (ChainValues& chain : c.machine.chains) {
    for (const std::size_t length : {kPlatformR, kLinkS, kRailR}) chain[length] *= size;
  }
  c.machine.home = {random.uniform(-20, 20), random.uniform(-20, 20), 0};
  Geometry truth = mechanism_of(c.machine).geometry;
  const double error_mm = std::pow(10, random.uniform(-2, 0.2)), error_rad = error_mm / 800;
  for (Chain& chain : truth.chains) {
    for (double* length : {&chain.r_mm, &chain.S_mm, &chain.R_mm, &chain.l_zero_mm, &chain.h_mm})
      *length += error_mm * random.normal();
    chain.alpha_rad += error_rad * random.normal();
    chain.beta_rad += error_rad * random.normal();
  }
  const double lead = random.below(4) == 0 ? 1.016 : 1;  // 25.4 for 25 on the first rail
  const TrackerSigma sigma{std::pow(10, random.uniform(-3, -1.3)),
                           rad_from_deg(std::pow(10, random.uniform(-3.5, -2)))};
  c.tracker = sigma;
  const int n =
      static_cast<int>(random.below(3) == 0 ? 8 + random.below(20) : 30 + random.below(150));
  const double reach = random.uniform(15, 110) * size;
  const double turn_rad = random.below(3) == 0 ? 0 : rad_from_deg(random.uniform(1, 10));
  const double digits = std::pow(10, -3.0 - static_cast<double>(random.below(4)));
  const bool lattice = random.below(2) == 0;
  const int side = static_cast<int>(std::ceil(std::sqrt(n)));
  const auto rounded_to = [&](double v) { return std::round(v / digits) * digits; };
  Displacements before = inverse(mechanism_of(c.machine).geometry, c.machine.home).l_mm;
  const Displacements home = before;
  for (int k = 0; k < n; ++k) {
    Reading r;
    r.seq = k + 1;
    r.set = k % 4 == 3 ? ReadingSet::validate : ReadingSet::identify;
    const double step = 2.0 / std::max(1, side - 1);
    r.target = lattice ? Pose{reach * (k % side * step - 1), reach * (k / side * step - 1), 0}
                       : Pose{random.uniform(-reach, reach), random.uniform(-reach, reach), 0};
    r.target.phi_rad = turn_rad * (random.uniform() * 2 - 1);
    const InverseResult at = inverse(mechanism_of(c.machine).geometry, r.target);
    if (!at.ok()) continue;
    r.conditions.cmd_mm = at.l_mm;
    r.conditions.from_mm = before;
    r.conditions.time_s = 20.0 * k;
    r.conditions.temp_degc = 20 + random.uniform();
    before = at.l_mm;
    Displacements l = at.l_mm;
    l[0] = home[0] + lead * (l[0] - home[0]);
    const ForwardResult seen = forward(truth, l, r.target);
    if (!seen.ok()) continue;
    r.measured = Pose{rounded_to(seen.pose.x_mm + sigma.xy_mm * random.normal()),
                      rounded_to(seen.pose.y_mm + sigma.xy_mm * random.normal()),
                      rad_from_deg(rounded_to(
                          deg_from_rad(seen.pose.phi_rad + sigma.phi_rad * random.normal())))};
    c.readings.push_back(r);
  }
  return c;
}

/// 80 readings and more, with phi, noise of 10 um and errors below a millimetre.
Campaign large() {
  for (std::uint64_t seed = 900;; ++seed) {
    Campaign c = made(seed);
    const bool fine = c.tracker->xy_mm > 5e-3 && c.tracker->phi_rad > rad_from_deg(1e-3);
    double turned = 0, off = 0;
    for (const Reading& r : c.readings) {
      turned = std::max(turned, std::abs(r.target.phi_rad));
      off = std::max(
          off, std::hypot(r.measured->x_mm - r.target.x_mm, r.measured->y_mm - r.target.y_mm));
    }
    if (c.readings.size() > 80 && fine && turned > 0.05 && off < 0.5) return c;
  }
}

using Mutation = std::function<void(Campaign&, Random&)>;

void each_pose(Campaign& c, const std::function<void(Pose&)>& change) {
  for (Reading& r : c.readings) change(*r.measured);
}
void each_command(Campaign& c, const std::function<void(Displacements&)>& change) {
  for (Reading& r : c.readings) change(r.conditions.cmd_mm);
}
void turn(Pose& p, double by) {
  const double x = p.x_mm, y = p.y_mm;
  p = {std::cos(by) * x - std::sin(by) * y, std::sin(by) * x + std::cos(by) * y, p.phi_rad + by};
}
void move_rows(Campaign& c, int by, std::optional<Pose> Reading::*column) {
  std::vector<Reading> rows = c.readings;
  const auto n = static_cast<int>(rows.size());
  for (int k = 0; k < n; ++k)
    c.readings[static_cast<std::size_t>(k)].*column =
        rows[static_cast<std::size_t>(std::clamp(k + by, 0, n - 1))].*column;
}

struct Kind {
  const char* kind;
  Mutation mutate;
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = {
      {"scale",
       [](Campaign& c, Random&) { each_pose(c, [](Pose& p) { p.x_mm /= 1e3, p.y_mm /= 1e3; }); }},
      {"scale",
       [](Campaign& c, Random&) { each_pose(c, [](Pose& p) { p.x_mm /= 25.4, p.y_mm /= 25.4; }); }},
      {"scale", [](Campaign& c, Random&) { each_command(c, [](Displacements& l) { l /= 25.4; }); }},
      {"scale",
       [](Campaign& c, Random&) {
         for (Reading& r : c.readings) r.target.x_mm /= 1e3, r.target.y_mm /= 1e3;
       }},
      {"radians",
       [](Campaign& c, Random&) {
         each_pose(c, [](Pose& p) { p.phi_rad = rad_from_deg(p.phi_rad); });
       }},
      {"radians",
       [](Campaign& c, Random&) { each_pose(c, [](Pose& p) { p.phi_rad *= 10.0 / 9; }); }},
      {"radians", [](Campaign& c, Random&) { each_pose(c, [](Pose& p) { p.phi_rad *= 60; }); }},
      {"frame_turned",
       [](Campaign& c, Random& random) {
         const double by = rad_from_deg(random.uniform(4, 170));
         each_pose(c, [by](Pose& p) { turn(p, by); });
       }},
      {"frame_shifted",
       [](Campaign& c, Random& random) {
         const double x = random.uniform(20, 2000), y = random.uniform(-900, 900);
         each_pose(c, [=](Pose& p) { p.x_mm += x, p.y_mm += y; });
       }},
      {"frame_mirrored",
       [](Campaign& c, Random&) { each_pose(c, [](Pose& p) { p.x_mm = -p.x_mm; }); }},
      {"frame_mirrored",
       [](Campaign& c, Random&) {
         each_pose(c, [](Pose& p) { p = {p.x_mm, -p.y_mm, -p.phi_rad}; });
       }},
      {"frame_mirrored",
       [](Campaign& c, Random&) { each_pose(c, [](Pose& p) { std::swap(p.x_mm, p.y_mm); }); }},
      {"drives_swapped",
       [](Campaign& c, Random& random) {
         const auto a = static_cast<Eigen::Index>(random.below(3)), b = (a + 1) % 3;
         each_command(c, [=](Displacements& l) { std::swap(l[a], l[b]); });
       }},
      {"drive_reversed",
       [](Campaign& c, Random& random) {
         const auto a = static_cast<Eigen::Index>(random.below(3));
         each_command(c, [=](Displacements& l) { l[a] = 500 - l[a]; });
       }},
      {"shifted_rows",
       [](Campaign& c, Random& random) {
         move_rows(c, random.below(2) == 0 ? 1 : -1, &Reading::measured);
       }},
      {"exchanged",
       [](Campaign& c, Random&) {
         for (Reading& r : c.readings) std::swap(r.target, *r.measured);
       }},
      {"deviations",
       [](Campaign& c, Random&) {
         for (Reading& r : c.readings)
           r.measured = Pose::from(r.measured->vector() - r.target.vector());
       }},
      {"deviations",
       [](Campaign& c, Random&) {
         for (Reading& r : c.readings)
           r.measured->x_mm -= r.target.x_mm, r.measured->y_mm -= r.target.y_mm;
       }},
      {"mechanism",
       [](Campaign& c, Random& random) {
         const double by = random.uniform(3, 40);
         for (ChainValues& chain : c.machine.chains) chain[kRailR] += by;
       }},
      {"mechanism",
       [](Campaign& c, Random& random) {
         const double by = random.uniform(3, 20);
         for (ChainValues& chain : c.machine.chains) chain[kPlatformR] += by;
       }},
      {"mechanism",
       [](Campaign& c, Random& random) {
         const double by = random.uniform(3, 40);
         for (ChainValues& chain : c.machine.chains) chain[kLinkS] += by;
       }},
      {"phi_offset",
       [](Campaign& c, Random& random) {
         const double by = rad_from_deg(random.uniform(10, 170));
         each_pose(c, [by](Pose& p) { p.phi_rad += by; });
       }},
  };
  return all;
}

struct Counts {
  int clean = 0, false_alarms = 0, mutated = 0, named = 0, missed = 0, misnamed = 0;
};

Counts counted(int rounds, std::uint64_t seed) {
  Counts counts;
  for (int k = 0; k < rounds; ++k) {
    const Campaign c = made(seed + static_cast<std::uint64_t>(k));
    const auto found = screened(c);  // doubts and remarks too
    ++counts.clean;
    if (!found.empty()) {
      ++counts.false_alarms;
      UNSCOPED_INFO("seed " << seed + static_cast<std::uint64_t>(k) << ": " << in_words(found[0]));
    }
    const Kind& kind = kinds()[static_cast<std::size_t>(k) % kinds().size()];
    Campaign wrong = c;
    Random random(seed + 1000 + static_cast<std::uint64_t>(k));
    kind.mutate(wrong, random);
    double turns = 0;
    for (const Reading& r : c.readings) turns = std::max(turns, std::abs(r.target.phi_rad));
    if (kind.kind == std::string("radians") && turns == 0) continue;  // sigma tells, or nothing
    ++counts.mutated;
    const auto named = gross_mistakes(wrong);
    const bool right = std::ranges::any_of(
        named, [&](const Suspicion& s) { return to_string(s.kind) == kind.kind; });
    counts.named += right ? 1 : 0;
    counts.missed += named.empty() ? 1 : 0;
    counts.misnamed += !named.empty() && !right ? 1 : 0;
    if (right && named.size() <= 2) continue;
    UNSCOPED_INFO(kind.kind << " of seed " << seed + static_cast<std::uint64_t>(k) << ": "
                            << (named.empty() ? "nothing" : in_words(named[0])));
  }
  return counts;
}

}  // namespace

TEST_CASE("gross mistakes are named in campaigns of all sizes, and sound ones are let in",
          "[measure]") {
  const Counts c = counted(38, 500);  // no chance in it: seeds are fixed
  CHECK(c.false_alarms == 0);
  CHECK(c.named >= c.mutated - 1);  // seed 533, deviations in a workspace of a few mm, is too small
}

TEST_CASE("what is doubtful is named with its readings, and nothing else", "[measure]") {
  const Campaign clean = large();
  const auto kinds_of = [](const Campaign& c) {
    std::vector<std::string> kinds;
    for (const Suspicion& s : screened(c)) kinds.push_back(to_string(s.kind));
    return kinds;
  };
  using Kinds = std::vector<std::string>;
  CHECK(kinds_of(clean).empty());
  struct Doubt {
    const char* kind;
    std::function<void(Campaign&)> make;
    std::vector<int> seqs;
  };
  const Doubt doubts[] = {
      {"nominal",
       [](Campaign& c) {
         for (Reading& r : c.readings) r.measured = r.target;
       },
       {}},
      {"nominal",  // with the digits of a printout
       [](Campaign& c) {
         for (Reading& r : c.readings) {
           r.measured = Pose{1e-3 * std::round(1e3 * r.target.x_mm),
                             1e-3 * std::round(1e3 * r.target.y_mm), r.target.phi_rad};
         }
       },
       {}},
      {"sigma_unit", [](Campaign& c) { c.tracker->xy_mm *= 1e3, c.tracker->phi_rad *= 1e3; }, {}},
      {"sigma_unit", [](Campaign& c) { c.tracker->xy_mm /= 1e3; }, {}},
      {"sigma_unit",
       [](Campaign& c) { c.tracker->phi_rad = rad_from_deg(c.tracker->phi_rad); },
       {}},
      {"temperature_unit",
       [](Campaign& c) {
         for (Reading& r : c.readings) *r.conditions.temp_degc += 273.15;
       },
       {}},
      {"temperature_unit", [](Campaign& c) { c.readings[7].conditions.temp_degc = 70; }, {8}},
      {"temperature_unit", [](Campaign& c) { c.readings[7].conditions.temp_degc = 0; }, {8}},
      {"temperature_unit",
       [](Campaign& c) {
         for (Reading& r : c.readings) r.conditions.temp_degc = 0;
       },
       {}},
      {"clock",
       [](Campaign& c) {
         for (Reading& r : c.readings) *r.conditions.time_s *= 1e3;
       },
       {}},
      {"clock",
       [](Campaign& c) {
         for (Reading& r : c.readings) r.conditions.time_s = 7;
       },
       {}},
      {"clock",
       [](Campaign& c) {
         for (std::size_t k = 40; k < c.readings.size(); ++k)
           *c.readings[k].conditions.time_s -= 1e3;
       },
       {41}},
      {"missing_cells", [](Campaign& c) { c.readings[11].conditions.temp_degc.reset(); }, {12}},
      {"stale", [](Campaign& c) { c.readings[30].measured = c.readings[29].measured; }, {31}},
      {"missed", [](Campaign& c) { c.readings[20].measured = Pose{}; }, {21}},
      {"far", [](Campaign& c) { c.readings[20].measured->x_mm += 4; }, {21}},
      {"copied",
       [](Campaign& c) {
         c.readings[3].target = c.readings[0].target;
         c.readings[3].conditions.cmd_mm = c.readings[0].conditions.cmd_mm;
         c.readings[3].measured = c.readings[0].measured;
       },
       {4}},
      {"duplicated",
       [](Campaign& c) {
         c.readings[9].target = c.readings[0].target;
         c.readings[9].conditions.cmd_mm = c.readings[0].conditions.cmd_mm;
         c.readings[9].measured = c.readings[0].measured;
       },
       {10}},
      {"other_commands", [](Campaign& c) { c.readings[4].conditions.cmd_mm[1] += 0.2; }, {5}},
  };
  for (const Doubt& doubt : doubts) {
    Campaign c = clean;
    doubt.make(c);
    CAPTURE(doubt.kind);
    CHECK(kinds_of(c) == Kinds{doubt.kind});
    const auto found = screened(c);
    if (!found.empty()) CHECK(found.front().seqs == doubt.seqs);
    CHECK_NOTHROW(require_sound(c, found, ""));
  }
  Campaign one = clean;  // at one orientation the scatter of phi tells radians
  for (Reading& r : one.readings) {
    r.target.phi_rad = 0;
    r.conditions.cmd_mm = inverse(mechanism_of(one.machine).geometry, r.target).l_mm;
  }
  Random random(9);
  for (Reading& r : one.readings)
    r.measured->phi_rad = rad_from_deg(one.tracker->phi_rad * random.normal());
  CHECK(kinds_of(one).front() == "radians");
  CHECK_THROWS_WITH(require_sound(one, screened(one), "hint"), Contains("radians"));
  for (Reading& r : one.readings)  // legs in error turn a platform as they move it: no radians
    r.measured->phi_rad = r.measured->phi_rad + 2e-3 * std::sin(r.target.x_mm / 30);
  CHECK(kinds_of(one).front() == "sigma_unit");
}

TEST_CASE("the words of a wrong unit of orientations say which", "[measure]") {
  for (const auto& [slope, words] : {std::pair{10.0 / 9, "are gradians"},
                                     {60.0, "are minutes of arc"},
                                     {3600.0, "are seconds of arc"},
                                     {kPi / 180, "are radians"},
                                     {180 / kPi, "converted from degrees twice"}}) {
    Campaign c = large();
    each_pose(c, [slope = slope](Pose& p) { p.phi_rad *= slope; });
    const auto found = gross_mistakes(c);
    REQUIRE(found.size() == 1);
    CHECK_THAT(found.front().what, Contains(words));
  }
}

TEST_CASE("one to three wrong readings are named, at the border too, and no good neighbour",
          "[measure]") {
  Random random(77);
  int n_wrong = 0;
  for (int trial = 0; trial < 24; ++trial) {
    Geometry truth = tests::random_geometry(random);
    Campaign c;
    c.name = "paper";
    c.machine = machine_of(paper_mechanism());
    const double lead = trial % 3 == 0 ? 0 : 0.003, backlash_mm = trial % 2 == 0 ? 0 : 0.08;
    Displacements lead_of;
    for (double& k : lead_of) k = lead * random.normal();
    c.readings = tests::measure(truth, tests::eighty_points(), random);
    const Displacements home = inverse(mechanism_of(c.machine).geometry, c.machine.home).l_mm;
    for (Reading& r : c.readings) {
      const Displacements way = r.conditions.cmd_mm - r.conditions.from_mm;
      const Displacements l = r.conditions.cmd_mm +
                              lead_of.cwiseProduct(r.conditions.cmd_mm - home) -
                              backlash_mm / 2 * way.cwiseSign();
      const Eigen::Vector3d more =
          forward(truth, l).pose.vector() - forward(truth, r.conditions.cmd_mm).pose.vector();
      r.measured = Pose::from(r.measured->vector() + more);
    }
    std::vector<int> wrong;
    for (int k = 0; k < 1 + trial % 3; ++k) {
      // of 80 points the last ones are outermost, as are the first: eighty_points walks outside in
      const std::size_t border = random.below(2) == 0 ? random.below(8) : 72 + random.below(8);
      const std::size_t at = random.below(3) == 0 ? random.below(80) : border;
      Reading& r = c.readings[at];
      if (std::ranges::find(wrong, r.seq) != wrong.end()) continue;
      const double turn_rad = random.uniform(0, 2 * kPi), off_mm = trial % 4 == 0 ? 30 : 4;
      r.measured->x_mm += off_mm * std::cos(turn_rad);
      r.measured->y_mm += off_mm * std::sin(turn_rad);
      wrong.push_back(r.seq);
    }
    std::vector<int> named;
    for (const Suspicion& s : bad_readings(c)) named.push_back(s.seqs.front());
    std::ranges::sort(wrong);
    std::ranges::sort(named);
    CAPTURE(trial);
    CHECK(named == wrong);
    n_wrong += static_cast<int>(wrong.size());
  }
  CHECK(n_wrong > 40);
}

TEST_CASE("far readings of heavy-tailed noise are no wrong readings, and one that is far is named",
          "[measure]") {
  // Student's t of 3 degrees, 240 readings: beyond 25 scales in 6 % of campaigns, of 60 in 0.5 %.
  Random random(77);
  const auto student3 = [&random] {
    double squares = 0;
    for (int k = 0; k < 3; ++k) squares += std::pow(random.normal(), 2);
    return random.normal() / std::sqrt(squares / 3);
  };
  int named = 0, missed = 0;
  constexpr int kCampaigns = 200;
  for (int campaign = 0; campaign < kCampaigns; ++campaign) {
    Campaign c;
    c.machine = machine_of(paper_mechanism());
    for (int k = 0; k < 240; ++k) {
      Reading r;
      r.seq = k + 1;
      r.target = {12.0 * (k % 16) - 90, 12.0 * (k / 16) - 84, 0};
      r.measured = Pose{r.target.x_mm * 1.002 + 0.01 * student3(),
                        r.target.y_mm * 0.999 + 0.01 * student3(), 1e-4 * student3()};
      c.readings.push_back(r);
    }
    named += bad_readings(c).empty() ? 0 : 1;
    c.readings[100].measured->x_mm += 2;
    const auto found = bad_readings(c);
    missed += std::ranges::any_of(
                  found, [](const Suspicion& s) { return s.seqs == std::vector<int>{101}; })
                  ? 0
                  : 1;
  }
  CHECK(named <= 4);  // 1 expected: more than 4 by chance once in 250
  CHECK(missed == 0);
}

TEST_CASE("a tracker's own frame is registered, and nothing else is", "[measure]") {
  const Campaign clean = large();
  Campaign c = clean;
  each_pose(c, [](Pose& p) {
    turn(p, 1.1);
    p.x_mm += 512;
  });
  const auto frame = fitted_frame(c);
  REQUIRE(frame);
  CHECK_THAT(frame->turn_rad, WithinAbs(1.1, 0.01));
  CHECK_THAT(frame->shift_x_mm, WithinAbs(512, 1));
  each_pose(c, [&](Pose& p) { p = in_robot_frame(*frame, p); });
  CHECK(gross_mistakes(c).empty());
  Campaign mirrored = clean;
  each_pose(mirrored, [](Pose& p) { p.x_mm = -p.x_mm; });
  CHECK_FALSE(fitted_frame(mirrored));
}

TEST_CASE("a session that has just begun names what needs no fit", "[measure]") {
  Campaign c = large();
  c.readings.resize(2);
  CHECK(gross_mistakes_of_few(c).empty());
  Campaign metres = c;
  each_pose(metres, [](Pose& p) { p.x_mm /= 1e3, p.y_mm /= 1e3; });
  REQUIRE_FALSE(gross_mistakes_of_few(metres).empty());
  CHECK(gross_mistakes_of_few(metres).size() <= 2);
  CHECK(std::ranges::any_of(gross_mistakes_of_few(metres),
                            [](const Suspicion& s) { return s.kind == Mistake::scale; }));
  Campaign mirrored = c;
  each_pose(mirrored, [](Pose& p) { p.x_mm = -p.x_mm; });
  REQUIRE_FALSE(gross_mistakes_of_few(mirrored).empty());
  CHECK(gross_mistakes_of_few(mirrored).front().kind == Mistake::frame_mirrored);
}

TEST_CASE("how often the screen is right", "[.study]") {
  const Counts c = counted(240, 10000);
  std::cout << c.clean << " clean, " << c.false_alarms << " false alarms; " << c.mutated
            << " mutated, " << c.named << " named, " << c.missed << " missed, " << c.misnamed
            << " misnamed\n";
}
