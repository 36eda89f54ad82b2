#include "app/session/policy.hpp"
#include "core/units.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;

namespace {

Plan line(double step_mm, double turn_deg) {
  Plan plan;
  for (int n = 0; n < 5; ++n) {
    const double far = n == 4 ? 30 : n;  // one long way
    plan.points.push_back(
        {.seq = n + 1, .target = {far * step_mm, 0, rad_from_deg(far * turn_deg)}});
  }
  plan.points.push_back({.seq = 6, .target = plan.points.back().target});  // a repeat is no step
  return plan;
}

}  // namespace

TEST_CASE("the gate on poses is well under half the plan's smallest step", "[session]") {
  for (const double step_mm : {0.2, 1.2, 2.0, 10.0, 25.0}) {
    CAPTURE(step_mm);
    CHECK_THAT(pose_gate({}, line(step_mm, 0), {}).xy_mm, WithinAbs(0.4 * step_mm, 1e-9));
  }
  CHECK(pose_gate({}, line(300, 0), {}).xy_mm == kMostGateMm);
  for (const double turn_deg : {0.1, 3.0}) {
    CHECK_THAT(pose_gate({}, line(10, turn_deg), {}).phi_rad,
               WithinAbs(rad_from_deg(0.4 * turn_deg), 1e-9));
  }
  CHECK_THAT(pose_gate({}, line(10, 0), {}).phi_rad, WithinAbs(rad_from_deg(2), 1e-9));
  // Noise is no other pose.
  CHECK(pose_gate({}, line(0.1, 0.1), TrackerSigma{0.1, 0.01}).xy_mm > 0.8);
  CHECK(pose_gate({}, line(0.1, 0.1), TrackerSigma{0.1, 0.01}).phi_rad > 0.08);
}

TEST_CASE("the first point is not taken for home, from which the platform comes", "[session]") {
  const Plan plan = line(10, 3);  // the first at 0, 0
  const auto first_mm = [&](double from_mm) {
    return pose_gate({}, plan, {}, Pose{from_mm, 0, 0}).first_xy_mm;
  };
  CHECK_THAT(first_mm(100), WithinAbs(5, 1e-9));
  CHECK_THAT(first_mm(6), WithinAbs(2.4, 1e-9));
  CHECK_THAT(first_mm(1.5), WithinAbs(1, 1e-9));
  CHECK_THAT(first_mm(0), WithinAbs(5, 1e-9));
  CHECK_THAT(pose_gate({}, plan, {}, Pose{0, 0, rad_from_deg(2)}).first_phi_rad,
             WithinAbs(rad_from_deg(0.8), 1e-9));
  CHECK(pose_gate({.gate_mm = 7}, plan, {}, Pose{1.5, 0, 0}).first_xy_mm == 7);
}

TEST_CASE("a gate that is stated holds, and is stored", "[session]") {
  Policy policy;
  CHECK_FALSE(read_policy(policy_json(policy)).gate_mm);
  policy.gate_mm = 7;
  policy.gate_deg = 1.5;
  const Policy again = read_policy(policy_json(policy));
  CHECK(again.gate_mm == 7);
  CHECK(again.gate_deg == 1.5);
  const PoseGate gate = pose_gate(again, line(10, 3), {});
  CHECK(gate.xy_mm == 7);
  CHECK(gate.first_xy_mm == 7);
  CHECK_THAT(gate.first_phi_rad, WithinAbs(rad_from_deg(1.5), 1e-12));
  policy.gate_deg = 0;
  CHECK_THROWS_WITH(validate(policy), Contains("gate_deg"));
}

}  // namespace trammel::session
