#pragma once
// A machine that is no 3-PRR, commanded as if it were: what no base and no name should explain.
// Of the project it uses the inverse kinematics alone, for the commands.

#include <cstdint>

#include "tests/study/campaigns.hpp"

namespace trammel::tests {

/// An XY stage that carries a turntable, seen by the same tracker.
struct ForeignDesign {
  double size = 1e-3;  // of each error at the end of its travel, over the travel
  bool turns = true;   // -6, 0 and 6 deg; else 0 alone
  bool yaws = true;    // the carriage turns along its guide, and the platform with it
  double sigma_xy_mm = 0.010;
  double sigma_phi_deg = 0.004;
};

/// 150 readings to fit and 40 others within 60 mm of the centre, each rail arriving from either
/// side over 1 to 30 mm. The stage goes to the target and misses it by its squareness, the scales,
/// curvatures and straightness of its axes and their yaw, each drawn from 0.3 to 1 of `size`.
HiddenCase make_foreign(const ForeignDesign& design, std::uint64_t seed);

}  // namespace trammel::tests
