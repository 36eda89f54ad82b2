// Nothing moves before the whole plan is known to be safe.

#include <array>
#include <cmath>
#include <limits>

#include "app/session/hands.hpp"
#include "app/session/plan_record.hpp"
#include "core/mechanism/clearance.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "core/mechanism/workspace.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"

namespace trammel::session {

using namespace tests;

namespace {

Pose random_pose(Random& random, double half_mm, double half_rad) {
  return {random.uniform(-half_mm, half_mm), random.uniform(-half_mm, half_mm),
          random.uniform(-half_rad, half_rad)};
}

/// Poses near home, all of them safe with every way between them: the control below.
Plan good_plan(Random& random) {
  PlanRequest request{.name = "good", .groups = {{}}};
  for (int n = 0; n < 4; ++n) request.groups[0].poses.push_back(random_pose(random, 60, 0.08));
  if (random.below(2) == 1) request.approaches = {Approach{1, -1, 0}};
  return build_plan(request);
}

/// Whether a way, all rails in proportion, can be gone and ends where it should: looked at ten
/// times as often as the check does, by nothing of its code but the kinematics.
bool way_is_good(const Mechanism& m, const Pose& from, const Pose& to) {
  const Displacements a = inverse(m.geometry, from).l_mm, b = inverse(m.geometry, to).l_mm;
  const int steps = static_cast<int>((b - a).cwiseAbs().maxCoeff() / 0.2) + 2;
  Pose pose = from;
  for (int k = 1; k <= steps; ++k) {
    const Displacements l = a + (b - a) * (static_cast<double>(k) / steps);
    const ForwardResult at = forward(m.geometry, l, pose);
    if (!at.ok()) return false;
    pose = at.pose;
    const InverseResult links = inverse(m.geometry, pose);
    const Singularity s = singularity(m.geometry, velocity_equation(m.geometry, pose, links));
    if (s.margin() < 0.09 || link_clearance_mm(m.geometry, links) < 9) return false;
  }
  return (pose.vector() - to.vector()).norm() < 1;
}

/// Two targets that can be stood on safely, and a way between them that can not be gone: the second
/// is turned beyond the singular poses.
std::optional<std::pair<Pose, Pose>> bad_way(Random& random, const Mechanism& m) {
  const auto fine = [&](const Pose& p) {
    const Reach r = reach(machine_of(m), p);
    const bool stands = r.ok() || r.status == Reach::Status::other_assembly;
    return stands && r.stroke_left_mm > 5 && r.singularity.margin() > 0.12 &&
           link_clearance_mm(m.geometry, inverse(m.geometry, p)) > 12;
  };
  const Pose a = random_pose(random, 100, 0.3);
  Pose b = random_pose(random, 100, 0);
  b.phi_rad = random.uniform(1.1, 1.9) * (random.below(2) == 0 ? 1 : -1);
  if (!fine(a) || !fine(b) || !way_is_good(m, m.home, a) || way_is_good(m, a, b)) {
    return std::nullopt;
  }
  return std::pair(a, b);
}

struct Made {
  Plan plan;
  double speed_mm_s = 20;
};

constexpr double kInf = std::numeric_limits<double>::infinity();

/// One kind of mistake, put into a good plan at a random point.
using Spoil = std::function<bool(Made&, Random&, const Mechanism&)>;
std::vector<std::pair<const char*, Spoil>> mistakes() {
  const auto at = [](Made& made, Random& random) -> Pose& {
    return made.plan.points[random.below(made.plan.points.size())].target;
  };
  return {
      {"not a number",
       [=](Made& made, Random& random, const Mechanism&) {
         const std::array<double, 3> bad = {std::nan(""), kInf, -kInf};
         Pose& pose = at(made, random);
         const double value = bad[random.below(3)];
         const std::uint64_t which = random.below(3);
         (which == 0 ? pose.x_mm : which == 1 ? pose.y_mm : pose.phi_rad) = value;
         return true;
       }},
      {"out of reach",
       [=](Made& made, Random& random, const Mechanism& m) {
         Pose& pose = at(made, random);
         const double angle = random.uniform(0, 6.28), far = random.uniform(300, 5000);
         pose = {far * std::cos(angle), far * std::sin(angle), 0};
         return !reach(machine_of(m), pose).ok();
       }},
      {"beyond a limit",
       [=](Made& made, Random& random, const Mechanism& m) {
         Pose& pose = at(made, random);
         pose = random_pose(random, 400, 0.5);
         const Reach r = reach(machine_of(m), pose);
         return r.status == Reach::Status::limit || (r.ok() && r.stroke_left_mm < 1.9);
       }},
      {"near singular",
       [=](Made& made, Random& random, const Mechanism& m) {
         Pose& pose = at(made, random);
         pose = random_pose(random, 250, 1.9);
         const Reach r = reach(machine_of(m), pose);
         return r.ok() && r.singularity.margin() < 0.09;
       }},
      {"too fast",
       [](Made& made, Random& random, const Mechanism&) {
         made.speed_mm_s = random.uniform(201, 1e6);
         return true;
       }},
      {"a way that can't be gone",
       [](Made& made, Random& random, const Mechanism& m) {
         const auto pair = bad_way(random, m);
         if (!pair) return false;
         made.plan = build_plan({.name = "way", .groups = {{"", {pair->first, pair->second}}}});
         return true;
       }},
  };
}

}  // namespace

TEST_CASE("1,200 unsafe plans are refused before anything moves, and good ones are not",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  const auto faults = std::make_shared<Faults>();
  double speed_mm_s = 20;
  faults->altered = [&](device::Devices& devices) { devices.motion.speed_mm_s = speed_mm_s; };
  Surroundings around;
  around.open = opening(faults);
  Random random(20240973);
  constexpr int kEach = 200;
  const Mechanism mechanism =
      mechanism_of(device::open_devices("sim:" + kPaperRobot, "sim").machine);
  for (const auto& [name, spoil] : mistakes()) {
    CAPTURE(name);
    int made = 0;
    for (int tries = 0; made < kEach && tries < 2'000'000; ++tries) {
      Made plan{good_plan(random), 20};
      if (!spoil(plan, random, mechanism)) continue;
      ++made;
      speed_mm_s = plan.speed_mm_s;
      const Outcome outcome = run(db, request_for(plan.plan), around);
      if (outcome.exit_code() == ExitCode::safety_stop && !outcome.violations.empty()) continue;
      CAPTURE(made);
      FAIL("not refused");
    }
    CHECK(made == kEach);
  }
  CHECK(faults->homes + faults->moves + faults->measures == 0);
  CHECK(store::list_campaigns(db).empty());
  speed_mm_s = 20;
  for (int n = 0; n < kEach; ++n) {
    const Outcome good = dry_run(request_for(good_plan(random)), NominalCorrection{}, around);
    CAPTURE(n);
    CHECK(good.violations.empty());
  }
}

TEST_CASE("each move is checked again when it is sent", "[session]") {
  const auto faults = std::make_shared<Faults>();
  const auto devices =
      std::make_shared<device::Devices>(opening(faults)("sim:" + kPaperRobot, "sim"));
  Hands hands(devices, {}, {}, {});
  REQUIRE_FALSE(hands.home().any());
  const Displacements home = hands.place().l_mm;
  REQUIRE_FALSE(hands.move(home + Displacements(5, 0, 0)).any());
  const int moves = faults->moves;
  for (const Displacements& bad :
       {Displacements(home[0], std::nan(""), home[2]), Displacements(home[0], kInf, home[2]),
        Displacements(599.5, home[1], home[2]), Displacements(0.5, home[1], home[2]),
        Displacements(500, 20, 20)}) {
    const Failure failure = hands.move(bad);
    CHECK(failure.cause == Failure::Cause::unsafe);
    CHECK(failure.exit_code() == ExitCode::safety_stop);
  }
  CHECK(faults->moves == moves);
  CHECK(hands.place().l_mm == home + Displacements(5, 0, 0));
}

TEST_CASE("a stage that was homed before is asked where it stands before it is moved",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  const auto faults = std::make_shared<Faults>();
  faults->altered = [](device::Devices& devices) {
    static_cast<void>(devices.stage->home());
    const Displacements home = devices.stage->stop().encoder_mm;
    static_cast<void>(
        devices.stage->move(home + Displacements(20, -10, 5), [] { return device::Status::ok; }));
  };
  Surroundings around;
  around.open = opening(faults);
  CHECK(run(db, request_for(small_plan()), around).state == State::done);
  CHECK(faults->stops == 2);  // one of them the test's own
  store::Connection calm = store::open(folder.path() / "calm.db", store::Access::create);
  REQUIRE(run(calm, request_for(small_plan()), {}).state == State::done);
  const auto expected = by_point(calm, "c", "s");
  for (const auto& [seq, reading] : by_point(db, "c", "s")) {
    CHECK(same_bits(reading, expected.at(seq)));
  }
}

TEST_CASE("a stage faster than it may be is refused, never slowed down in silence", "[session]") {
  const auto faults = std::make_shared<Faults>();
  device::Motion motion{.speed_mm_s = 50, .max_speed_mm_s = 40};
  faults->altered = [&](device::Devices& devices) { devices.motion = motion; };
  Surroundings around;
  around.open = opening(faults);
  const Request request = request_for(small_plan());
  const Outcome fast = dry_run(request, NominalCorrection{}, around);
  REQUIRE(fast.violations.size() == 1);
  CHECK(fast.violations[0].what == Violation::What::too_fast);
  CHECK_THAT(describe(fast.violations[0]), Contains("50.0 mm/s, limit 40.0 mm/s"));
  motion.speed_mm_s = 40;
  CHECK(dry_run(request, NominalCorrection{}, around).violations.empty());
}

TEST_CASE("a real stage needs a check of this very plan, on this mechanism, no laxer",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  const auto faults = std::make_shared<Faults>();
  faults->altered = [](device::Devices& devices) {
    devices.simulated = devices.virtual_time = false;
  };
  Surroundings around;
  around.open = opening(faults);
  around.sleep = [](double) {};
  Request request = request_for(small_plan());
  const Mechanism mechanism = paper_mechanism();
  const std::string file = (folder.path() / "check.json").string();
  const auto refused = [&](const std::string& why) {
    const Outcome outcome = run(db, request, around);
    CHECK(outcome.exit_code() == ExitCode::safety_stop);
    REQUIRE(outcome.missing.size() == 1);
    CHECK_THAT(outcome.missing[0], Contains(why));
    CHECK(dry_run(request, NominalCorrection{}, around).missing == outcome.missing);
    CHECK(faults->homes == 0);
  };
  refused("needs a check of this plan");
  request.plan_check = file;
  CHECK_THROWS_AS(run(db, request, around), NotFoundError);
  Plan other = small_plan();
  other.points[3].target.x_mm += 1e-9;
  write_plan_record(file, other, machine_of(mechanism), {}, Existing::replace);
  refused("of another plan");
  Mechanism longer = mechanism;
  longer.geometry.chains[1].S_mm += 0.001;
  write_plan_record(file, small_plan(), machine_of(longer), {}, Existing::replace);
  refused("of another plan or mechanism");
  CheckOptions lax;
  lax.singularity_margin = 0.05;
  write_plan_record(file, small_plan(), machine_of(mechanism), lax, Existing::replace);
  refused("singularity_margin");
  write_plan_record(file, small_plan(), machine_of(mechanism), {}, Existing::replace);
  CHECK(schema_errors(nlohmann::json::parse(read_text(file)), "plan-record.schema.json") == "");
  CHECK(run(db, request, around).state == State::done);
  folder.write("check.json", "{\"schema\": \"trammel/plan/1\"}");
  CHECK_THROWS_AS(read_plan_record(file), InputError);
}

}  // namespace trammel::session
