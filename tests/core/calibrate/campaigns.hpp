#pragma once
// Campaigns for calibration tests: golden copies, and a robot with geometric errors made here.

#include <vector>

#include "core/measure/reading.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/workspace.hpp"

namespace trammel::tests {

inline constexpr TrackerSigma kSigma{0.010, rad_from_deg(0.004)};

/// Readings of a golden campaign (paper's robot, sigmas kSigma).
inline std::vector<Reading> golden_readings(const std::string& name) {
  const Table t = read_table("core/calibrate/golden/lsq_" + name + ".csv");
  std::vector<Reading> readings;
  for (std::size_t k = 0; k < t.rows.size(); ++k) {
    Reading r;
    r.seq = static_cast<int>(t.number(k, "seq"));
    r.set = t.text(k, "set") == "identify" ? ReadingSet::identify : ReadingSet::validate;
    r.conditions.epoch = static_cast<int>(t.number(k, "epoch"));
    r.target = {t.number(k, "target_x_mm"), t.number(k, "target_y_mm"),
                rad_from_deg(t.number(k, "target_phi_deg"))};
    r.conditions.cmd_mm = {t.number(k, "cmd_l1_mm"), t.number(k, "cmd_l2_mm"),
                           t.number(k, "cmd_l3_mm")};
    r.measured =
        Pose{t.number(k, "x_mm"), t.number(k, "y_mm"), rad_from_deg(t.number(k, "phi_deg"))};
    readings.push_back(r);
  }
  return readings;
}

inline std::vector<Reading> of_set(const std::vector<Reading>& all, ReadingSet set) {
  std::vector<Reading> some;
  for (const Reading& r : all) {
    if (r.set == set) some.push_back(r);
  }
  return some;
}

/// A robot of `truth` sent to `targets` by the nominal inverse kinematics, read with noise.
inline std::vector<Reading> measure(const Geometry& truth, const std::vector<Pose>& targets,
                                    Random& random, const TrackerSigma& sigma = kSigma) {
  const Mechanism nominal = paper_mechanism();
  std::vector<Reading> readings;
  for (const Pose& target : targets) {
    Reading r;
    r.seq = static_cast<int>(readings.size()) + 1;
    r.target = target;
    r.conditions.cmd_mm = inverse(nominal.geometry, target).l_mm;
    r.conditions.from_mm =
        readings.empty() ? r.conditions.cmd_mm : readings.back().conditions.cmd_mm;
    Pose pose = forward(truth, r.conditions.cmd_mm).pose;
    pose.x_mm += sigma.xy_mm * random.normal();
    pose.y_mm += sigma.xy_mm * random.normal();
    pose.phi_rad += sigma.phi_rad * random.normal();
    r.measured = pose;
    readings.push_back(r);
  }
  return readings;
}

/// The paper's 80 points (axes and diagonals, every 10 mm), all at one orientation.
inline std::vector<Pose> eighty_points(double phi_rad = 0) {
  std::vector<Pose> points;
  for (int k = -10; k <= 10; ++k) {
    if (k == 0) continue;
    const double d = 10.0 * k;
    for (const auto& [x, y] : {std::pair{d, 0.0}, {0.0, d}, {d, d}, {d, -d}}) {
      points.push_back({x, y, phi_rad});
    }
  }
  return points;
}

inline std::vector<Pose> random_poses(int n, Random& random) {
  std::vector<Pose> poses;
  for (int k = 0; k < n; ++k) poses.push_back(random_pose(random));
  return poses;
}

}  // namespace trammel::tests
