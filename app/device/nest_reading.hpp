#pragma once
// From points of nests in the tracker's frame to the report of a pose.

#include <optional>
#include <string>
#include <vector>

#include "app/device/device.hpp"
#include "core/measure/nests.hpp"

namespace trammel::device {

struct NestSettings {
  NestFrame frame;
  double sigma_mm = 0;  // one standard deviation of one coordinate of one point
  std::optional<double> out_of_plane_mm = {};  // a platform that tilts more is not believed
};

/// The pose by core/measure/nests.hpp. unstable: the points are not those of a rigid body, or the
/// platform tilts beyond the gate; fault: the triangle is turned over (two nests swapped). `detail`
/// says by how much.
PoseReport pose_report(const std::vector<NestPoint>& points, const NestSettings& settings,
                       std::string raw_reply);

/// A platform's frame seen by the tracker, as a pose in the plane of the base.
PoseReport pose_report(const Eigen::Isometry3d& T_T_P, const NestSettings& settings,
                       std::string raw_reply);

/// What `pose_report` leaves of sigma_mm: root mean square of x and y, and phi. Throws InputError
/// for nests that leave phi unobserved.
TrackerSigma sigma_of_pose(const NestSettings& settings);

}  // namespace trammel::device
