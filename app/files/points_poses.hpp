#pragma once
// Rows of a points file -> poses of the platform in the robot's frame, and what was left out.

#include <string>
#include <vector>

#include "app/files/layout.hpp"
#include "core/measure/base_frame.hpp"
#include "core/plan/plan.hpp"

namespace trammel {

/// A row, or the pose it was for, that no reading was made of.
struct DroppedRow {
  std::vector<int> lines;
  std::string why;  // "miss (0 0 0)", "gross outlier: 243.1 mm from the median of its place", …
};

/// How one side of the nests' triangle was seen over all poses.
struct SideSeen {
  std::string side;       // "P1-P2"
  double off_mm = 0;      // median of measured - layout
  double scatter_mm = 0;  // 1.4826 x the median distance from that: a ghost does not count
};

struct DriftSeen {
  int line = 0;  // where the visit begins
  BaseDrift drift;
  int epoch = 1;  // of the readings that follow
};

/// One standing of the platform: a repeat at a planned pose.
struct PointsPose {
  int pose = 0;    // seq in the plan
  int repeat = 1;  // from 1
  int epoch = 1;
  std::vector<NestPoint> points = {};      // in the tracker's frame
  std::vector<const PointRow*> used = {};  // rows that they come from, by line
  std::vector<int> lines = {};             // of all its rows
  NestPose seen = {};                      // ok: makes a reading
};

/// The point that the platform stood at.
const PlannedPoint& planned(const Plan& plan, const PointsPose& pose);

struct PointsPoses {
  std::vector<PointsPose> poses;  // in the order of the file
  std::vector<DroppedRow> dropped;
  std::vector<SideSeen> sides;
  std::vector<DriftSeen> drifts;
  BaseFrame base = {};  // base_nests: the first registration
};

/// Rules. The tracker's frame: as the layout says. base_nests: registered by the first visit; a
/// later visit that has moved beyond chance (base_drift) opens a new epoch, registered anew.
/// zeroing: plane of motion through all poses, then the first pose planned at `home` reads home.
/// Outliers: per nest and pose among five rows or more (screen); then whole poses that stand
/// farther from their targets than max(10 x median, 1 mm). The orientation is the one nearest the
/// target's.
/// @throws InputError  as assign_rows; more than half of the poses not rigid or mirrored (says how
///                     the sides were seen); no pose at home to zero to; no base nests
/// Proof: points_campaign_test.cpp.
PointsPoses poses_of_points(const PointsFile& file, const Layout& layout, const Pose& home,
                            const Plan& plan);

}  // namespace trammel
