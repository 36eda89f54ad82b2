#include "app/device/nest_reading.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"

namespace trammel::device {

namespace {

Status status_of_nests(NestStatus status) {
  switch (status) {
    case NestStatus::ok:
      return Status::ok;
    case NestStatus::not_rigid:
      return Status::unstable;
    case NestStatus::no_nests:
      return Status::beam_broken;
    case NestStatus::mirrored:
    case NestStatus::phi_not_observed:
      return Status::fault;
  }
  return Status::fault;
}

}  // namespace

PoseReport pose_report(const std::vector<NestPoint>& points, const NestSettings& settings,
                       std::string raw_reply) {
  const NestPose seen = pose_of_nests(points, settings.frame, settings.sigma_mm);
  PoseReport report{status_of_nests(seen.status), "", {}, std::move(raw_reply)};
  const NestQuality& q = seen.quality;
  if (!seen.ok()) {
    report.detail = name_of(seen.status);
    if (seen.status == NestStatus::not_rigid) {
      report.detail += fmt::format(": side {} is {:+.4f} mm off, chance leaves {:.4f}", q.side,
                                   q.side_mm, q.side_limit_mm);
    }
    return report;
  }
  if (settings.out_of_plane_mm && !(q.out_of_plane_mm <= *settings.out_of_plane_mm)) {
    report.status = Status::unstable;
    report.detail =
        fmt::format("the platform is {:.4f} mm out of its plane, at most {} are allowed",
                    q.out_of_plane_mm, *settings.out_of_plane_mm);
    return report;
  }
  report.pose = seen.pose;
  return report;
}

PoseReport pose_report(const Eigen::Isometry3d& T_T_P, const NestSettings& settings,
                       std::string raw_reply) {
  const Eigen::Isometry3d T_B_P = settings.frame.T_B_T * T_T_P;
  const Eigen::Matrix3d R = T_B_P.linear();
  return {Status::ok,
          "",
          {T_B_P.translation().x(), T_B_P.translation().y(), std::atan2(R(1, 0), R(0, 0))},
          std::move(raw_reply)};
}

TrackerSigma sigma_of_pose(const NestSettings& settings) {
  std::vector<NestPoint> at_home = settings.frame.body;
  for (NestPoint& nest : at_home) nest.at_mm = settings.frame.T_B_T.inverse() * nest.at_mm;
  const NestPose pose = pose_of_nests(at_home, settings.frame, settings.sigma_mm);
  if (!pose.ok()) {
    throw InputError({.what = std::string("these nests give no pose: ") + name_of(pose.status),
                      .where = {.field = "nests"},
                      .expected = "two or three nests, apart from each other"});
  }
  return {std::sqrt((pose.covariance(0, 0) + pose.covariance(1, 1)) / 2),
          std::sqrt(pose.covariance(2, 2))};
}

}  // namespace trammel::device
