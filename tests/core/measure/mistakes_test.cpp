// Gross mistakes put into clean campaigns, one of each kind, and campaigns in which all is sound.

#include <cmath>

#include "core/measure/gross.hpp"
#include "core/measure/screen.hpp"
#include "core/units.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

/// The clean campaign with every measured pose replaced.
template <typename F>
Campaign with_poses(Campaign campaign, F f) {
  for (Reading& r : campaign.readings) r.measured = f(*r.measured);
  return campaign;
}

/// The clean campaign with every command replaced: what the plan wrote, not what the drives did.
template <typename F>
Campaign with_commands(Campaign campaign, F f) {
  for (Reading& r : campaign.readings) r.conditions.cmd_mm = f(r.conditions.cmd_mm);
  return campaign;
}

std::vector<std::string> kinds_of(const Campaign& campaign) {
  std::vector<std::string> kinds;
  for (const Suspicion& s : gross_mistakes(campaign)) kinds.push_back(to_string(s.kind));
  return kinds;
}

void check_named(const Campaign& campaign, const std::string& kind) {
  const auto kinds = kinds_of(campaign);
  CAPTURE(kind, kinds);
  CHECK(kinds.size() <= 2);
  CHECK(std::count(kinds.begin(), kinds.end(), kind) == 1);
}

}  // namespace

TEST_CASE("each gross mistake is named by its kind, two kinds at most", "[measure]") {
  const Campaign clean = hide({}, 0, 61).campaign;
  const double home_mm = 261.8;
  check_named(with_commands(clean, [](Displacements l) { return Displacements(l[1], l[0], l[2]); }),
              "drives_swapped");
  check_named(with_commands(clean,
                            [&](Displacements l) {
                              l[1] = 2 * home_mm - l[1];
                              return l;
                            }),
              "drive_reversed");
  check_named(with_poses(clean,
                         [](Pose p) {
                           p.phi_rad += rad_from_deg(120);
                           return p;
                         }),
              "phi_offset");
  check_named(with_poses(clean,
                         [](const Pose& p) {
                           return Pose{-p.y_mm, p.x_mm, p.phi_rad + kPi / 2};
                         }),
              "frame_turned");
  check_named(with_poses(clean,
                         [](const Pose& p) {
                           return Pose{p.x_mm, -p.y_mm, -p.phi_rad};
                         }),
              "frame_mirrored");
  check_named(with_poses(clean,
                         [](const Pose& p) {
                           return Pose{p.x_mm / 25.4, p.y_mm / 25.4, p.phi_rad};
                         }),
              "scale");
  Campaign shifted = clean;
  for (std::size_t i = shifted.readings.size(); i-- > 1;)
    shifted.readings[i].measured = shifted.readings[i - 1].measured;
  check_named(shifted, "shifted_rows");
  Campaign exchanged = clean;
  for (Reading& r : exchanged.readings) {
    const Pose target = r.target;
    r.target = *r.measured;
    r.measured = target;
  }
  check_named(exchanged, "exchanged");
}

TEST_CASE("a mistake in one column, or in the rows of one export, is named", "[measure]") {
  const Campaign clean = hide({}, 0, 61).campaign;
  const auto third = [](const Reading& r) { return r.seq % 3 == 0; };
  const auto late = [&clean](const Reading& r) {
    return r.seq > static_cast<int>(clean.readings.size()) / 2;
  };
  const auto part = [](Campaign campaign, auto is_wrong, auto f, bool as_a_set) {
    for (Reading& r : campaign.readings) {
      if (as_a_set) r.set = is_wrong(r) ? ReadingSet::validate : ReadingSet::identify;
      if (is_wrong(r)) r.measured = f(*r.measured);
    }
    return campaign;
  };
  const auto radians = [](Pose p) {
    p.phi_rad = rad_from_deg(p.phi_rad);
    return p;
  };
  const auto metres = [](const Pose& p) { return Pose{p.x_mm / 1e3, p.y_mm / 1e3, p.phi_rad}; };
  const auto mirrored = [](const Pose& p) { return Pose{p.x_mm, -p.y_mm, -p.phi_rad}; };
  check_named(part(clean, third, radians, true), "radians");
  check_named(part(clean, third, mirrored, true), "frame_mirrored");
  check_named(part(clean, late, metres, false), "scale");
  check_named(part(clean, third, metres, false), "scale");
  const Campaign narrow = hide({}, 0, 65, {.reach = 0.5}).campaign;  // within 2 deg
  check_named(part(narrow, third, radians, true), "radians");
  check_named(with_poses(narrow,
                         [](Pose p) {
                           p.phi_rad /= 0.9;
                           return p;
                         }),
              "radians");
  check_named(with_poses(clean,
                         [](Pose p) {
                           p.x_mm /= 1e3;
                           return p;
                         }),
              "scale");
  check_named(with_poses(clean,
                         [](const Pose& p) {
                           return Pose{1.1 * p.x_mm, 1.1 * p.y_mm, p.phi_rad};
                         }),
              "scale");  // of no unit, and of no machine
  Campaign deviations = clean;
  for (Reading& r : deviations.readings) {
    r.measured->x_mm = 1e3 * (r.measured->x_mm - r.target.x_mm);
    r.measured->y_mm = 1e3 * (r.measured->y_mm - r.target.y_mm);
  }
  check_named(deviations, "deviations");
  Campaign shifted = clean;
  for (std::size_t i = shifted.readings.size(); i-- > 3;)
    shifted.readings[i].measured = shifted.readings[i - 3].measured;
  check_named(shifted, "shifted_rows");
}

TEST_CASE("wires, columns and nominals of a part of the rows are named", "[measure]") {
  const Campaign clean = hide({}, 0, 61).campaign;
  const auto in_third = [&clean](auto make) {
    Campaign campaign = clean;
    for (Reading& r : campaign.readings) {
      if (r.seq % 3 == 0) make(r);
    }
    return campaign;
  };
  check_named(
      in_third([](Reading& r) { std::swap(r.conditions.cmd_mm[0], r.conditions.cmd_mm[1]); }),
      "drives_swapped");
  check_named(in_third([](Reading& r) {
                const Pose target = r.target;
                r.target = *r.measured;
                r.measured = target;
              }),
              "exchanged");
  const std::vector<Suspicion> nominals =
      screened(in_third([](Reading& r) { r.measured = r.target; }));
  REQUIRE(nominals.size() == 1);
  CHECK(nominals.front().kind == Mistake::nominal);
  CHECK(nominals.front().seqs.size() == clean.readings.size() / 3);
}

TEST_CASE("a walk under a correction is screened for itself", "[measure]") {
  const Campaign clean = hide({}, 0, 61).campaign;
  CorrectedWalk walk{.name = "again", .readings = clean.readings};
  for (Reading& r : walk.readings) {
    r.seq += 1000;
    for (int i = 0; i < kChains; ++i)  // what a correction may well ask for
      r.conditions.cmd_mm[i] += 0.3 * std::sin(r.target.x_mm / 40 + i);
  }
  const auto found_with = [&clean, &walk](auto make) {
    CorrectedWalk made = walk;
    for (Reading& r : made.readings) make(r);
    return screened(clean, {}, std::vector{made});
  };
  CHECK(found_with([](Reading&) {}).empty());
  const auto metres = found_with([](Reading& r) {
    r.measured->x_mm /= 1e3;
    r.measured->y_mm /= 1e3;
  });
  REQUIRE(metres.size() == 1);
  CHECK(metres.front().kind == Mistake::scale);
  CHECK(metres.front().seqs.size() == walk.readings.size());
  CHECK_THAT(metres.front().what, Contains("again"));
  const auto nominal = found_with([](Reading& r) { r.measured = r.target; });
  REQUIRE_FALSE(nominal.empty());
  CHECK(nominal.front().kind == Mistake::nominal);
  const auto one = found_with([](Reading& r) {
    if (r.seq == 1017) r.measured->x_mm += 7;
  });
  REQUIRE(one.size() == 1);
  CHECK(one.front().seqs == std::vector{1017});
}

TEST_CASE("one or two wrong readings of six to twelve are named, and no mechanism is accused",
          "[measure]") {
  const Campaign clean = hide({"lead_scale"}, 100, 68).campaign;
  for (const std::size_t n : {6U, 7U, 8U, 10U, 12U}) {
    Campaign campaign = clean;
    for (std::size_t k = 0; k < n; ++k)
      campaign.readings[k] = clean.readings[k * clean.readings.size() / n];
    campaign.readings.resize(n);
    CHECK(screened(campaign).empty());
    std::vector<int> wrong;
    for (const std::size_t k : {n / 2, n - 1}) {
      campaign.readings[k].measured->x_mm += 45;
      campaign.readings[k].measured->y_mm -= 70;
      wrong.push_back(campaign.readings[k].seq);
      std::vector<int> named;
      for (const Suspicion& s : screened(campaign)) {
        CHECK(s.kind == Mistake::far);
        named.insert(named.end(), s.seqs.begin(), s.seqs.end());
      }
      CAPTURE(n);
      CHECK(named == wrong);
    }
  }
}

TEST_CASE("mistakes of a stage of a millimetre are named, of all rows and of a part", "[measure]") {
  const Campaign clean = hide({}, 0, 69, design_of("3-PPR")).campaign;
  CHECK(screened(clean).empty());
  for (const int every : {1, 3}) {
    const auto in_part = [&clean, every](auto make) {
      Campaign campaign = clean;
      for (Reading& r : campaign.readings) {
        if (r.seq % every == 0) make(*r.measured);
      }
      return campaign;
    };
    CAPTURE(every);
    check_named(in_part([](Pose& p) { p.x_mm /= 1e3, p.y_mm /= 1e3; }), "scale");
    check_named(in_part([](Pose& p) { p.x_mm = -p.x_mm; }), "frame_mirrored");
  }
}

TEST_CASE("a small plan that is walked again under a correction is no shift of rows", "[measure]") {
  Campaign campaign = hide({"lead_scale"}, 300, 66).campaign;
  std::erase_if(campaign.readings, [](const Reading& r) { return r.seq > 60; });
  std::vector<Reading> judge(campaign.readings.begin(), campaign.readings.begin() + 9);
  for (const bool corrected : {false, true}) {
    for (Reading r : judge) {
      r.seq = static_cast<int>(campaign.readings.size()) + 1;
      r.set = ReadingSet::validate;
      if (corrected) r.measured = r.target;
      campaign.readings.push_back(r);
    }
  }
  CHECK(kinds_of(campaign).empty());
}

TEST_CASE("the frame of a stage without an orientation is fitted by its places", "[measure]") {
  const Campaign clean = hide({}, 0, 67, design_of("XY")).campaign;
  const double turn = rad_from_deg(30);
  const Campaign turned = with_poses(clean, [turn](const Pose& p) {
    return Pose{std::cos(turn) * p.x_mm - std::sin(turn) * p.y_mm + 12,
                std::sin(turn) * p.x_mm + std::cos(turn) * p.y_mm - 7, p.phi_rad};
  });
  const auto own = fitted_frame(clean), frame = fitted_frame(turned);
  REQUIRE(own);
  REQUIRE(frame);
  CHECK_THAT(frame->turn_rad - own->turn_rad, WithinAbs(turn, 1e-9));
  for (std::size_t k = 0; k < clean.readings.size(); ++k) {
    const Pose a = in_robot_frame(*own, *clean.readings[k].measured);
    const Pose b = in_robot_frame(*frame, *turned.readings[k].measured);
    CHECK_THAT(b.x_mm, WithinAbs(a.x_mm, 1e-9));
    CHECK_THAT(b.y_mm, WithinAbs(a.y_mm, 1e-9));
  }
}

TEST_CASE("no part of a sound campaign is suspected: 0 of 60", "[measure]") {
  for (std::uint64_t seed = 7100; seed < 7160; ++seed) {
    const Design design{.name = seed % 2 == 0 ? "rich" : "paper",
                        .reach = seed % 3 == 0 ? 0.15 : 1,
                        .epochs = 1 + static_cast<int>(seed % 3),
                        .student = seed % 5 == 0 ? 3.0 : 0.0};
    Campaign campaign = hide({}, 0, seed, design).campaign;
    for (Reading& r : campaign.readings) {
      if (r.seq % 4 == 0) r.set = ReadingSet::validate;
    }
    CAPTURE(seed);
    CHECK(kinds_of(campaign).empty());
  }
}

TEST_CASE("what is sound is not suspected, with effects of several millimetres too", "[measure]") {
  CHECK(kinds_of(hide({}, 0, 62).campaign).empty());
  CHECK(kinds_of(hide({}, 0, 62, {.name = "paper"}).campaign).empty());
  for (const char* name : {"lead_scale", "backlash", "platform_load", "guide_bow"}) {
    CAPTURE(name);
    CHECK(kinds_of(hide({name}, 500, 63).campaign).empty());
  }
  Campaign inches = hide({}, 0, 64).campaign;  // a lead of 25.4 for 25 is an effect, no mistake
  for (Reading& r : inches.readings)
    r.conditions.cmd_mm[0] = 261.8 + (r.conditions.cmd_mm[0] - 261.8) / 1.016;
  CHECK(kinds_of(inches).empty());
}
