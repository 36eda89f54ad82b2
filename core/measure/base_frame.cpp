#include "core/measure/base_frame.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/error.hpp"
#include "core/statistics/limits.hpp"

namespace trammel {

namespace {

constexpr double kAtOrigin_mm = 1e-6;  // rounding of a file
constexpr double kLeastUp = 0.1;  // of `up` along the normal: less does not tell the sides apart

std::map<std::string, Eigen::Vector3d> by_name(const std::vector<NestPoint>& points) {
  std::map<std::string, Eigen::Vector3d> named;
  for (const NestPoint& p : points) {
    const bool is_new = named.emplace(p.nest, p.at_mm).second;
    if (is_new && p.at_mm.allFinite()) continue;
    throw InputError(
        {.what = is_new ? "a base nest's place is not a number" : "duplicate base nest",
         .where = {.field = p.nest}});
  }
  return named;
}

/// The nests of both lists, as columns.
struct InCommon {
  std::vector<std::string> names;
  Eigen::Matrix3Xd first, second;
};

InCommon in_common(const std::vector<NestPoint>& first, const std::vector<NestPoint>& second) {
  const auto a = by_name(first), b = by_name(second);
  InCommon both;
  for (const auto& [name, at] : a) {
    if (b.contains(name)) both.names.push_back(name);
  }
  const auto n = static_cast<Eigen::Index>(both.names.size());
  both.first.resize(3, n);
  both.second.resize(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    both.first.col(k) = a.at(both.names[static_cast<std::size_t>(k)]);
    both.second.col(k) = b.at(both.names[static_cast<std::size_t>(k)]);
  }
  return both;
}

std::vector<Eigen::Vector3d> columns(const Eigen::Matrix3Xd& points) {
  std::vector<Eigen::Vector3d> all;
  for (Eigen::Index k = 0; k < points.cols(); ++k) all.emplace_back(points.col(k));
  return all;
}

Eigen::Isometry3d planar_move(const Pose& move, double lift_mm) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(move.phi_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() << move.x_mm, move.y_mm, lift_mm;
  return T;
}

}  // namespace

BaseFrame frame_of_base(const std::vector<NestPoint>& measured,
                        const std::vector<NestPoint>& base) {
  const InCommon both = in_common(measured, base);
  if (!fit_plane(columns(both.second)).observed || !fit_plane(columns(both.first)).observed) {
    throw InputError({.what = "the base nests span no plane",
                      .where = {.field = "base"},
                      .got = std::to_string(both.names.size()) + " nests measured" +
                             (both.names.size() < 3 ? "" : ", near one line"),
                      .expected = "three or more, not in one line"});
  }
  BaseFrame frame;
  frame.n_nests = static_cast<int>(both.names.size());
  frame.T_B_T.matrix() = Eigen::umeyama(both.first, both.second, false);
  double sum_mm2 = 0;
  for (Eigen::Index k = 0; k < both.first.cols(); ++k) {
    const double r = (both.second.col(k) - frame.T_B_T * both.first.col(k)).norm();
    sum_mm2 += r * r;
    if (k > 0 && r <= frame.max_mm) continue;
    frame.max_mm = r;
    frame.worst = both.names[static_cast<std::size_t>(k)];
  }
  frame.rms_mm = std::sqrt(sum_mm2 / (3.0 * frame.n_nests - 6));
  return frame;
}

Plane motion_plane(std::span<const NestPoint> measured) {
  struct Sum {
    Eigen::Vector3d mm = Eigen::Vector3d::Zero();
    double n = 0;
  };
  std::map<std::string, Sum> of_nest;
  Eigen::Vector3d all_mm = Eigen::Vector3d::Zero();
  for (const NestPoint& p : measured) {
    Sum& sum = of_nest[p.nest];
    sum.mm += p.at_mm;
    sum.n += 1;
    all_mm += p.at_mm;
  }
  std::vector<Eigen::Vector3d> about;
  for (const NestPoint& p : measured) {
    about.emplace_back(p.at_mm - of_nest[p.nest].mm / of_nest[p.nest].n);
  }
  Plane plane = fit_plane(about);
  if (!measured.empty()) plane.centre_mm = all_mm / static_cast<double>(measured.size());
  return plane;
}

Eigen::Isometry3d frame_on_plane(const Plane& plane, const Eigen::Vector3d& up) {
  if (!plane.observed) {
    throw InputError({.what = "the points show no plane of motion",
                      .expected = "poses that differ in x and in y"});
  }
  const double along = plane.normal.dot(up.normalized());
  if (!(std::abs(along) >= kLeastUp)) {
    throw InputError({.what = "up lies in the plane of motion: it does not tell its sides apart",
                      .where = {.field = "up"},
                      .expected = "the tracker's axis that points to the side of +Z"});
  }
  const Eigen::Vector3d z = along > 0 ? plane.normal : Eigen::Vector3d(-plane.normal);
  const bool x_stands = std::abs(z.x()) > 0.9;
  const Eigen::Vector3d towards = x_stands ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d x = (towards - z * z.dot(towards)).normalized();
  Eigen::Isometry3d T_T_B = Eigen::Isometry3d::Identity();
  T_T_B.linear() << x, z.cross(x), z;
  T_T_B.translation() = plane.centre_mm;
  return T_T_B.inverse();
}

Eigen::Isometry3d zeroed(const Eigen::Isometry3d& T_B_T, const NestPose& at_home,
                         const Pose& home) {
  const bool turns = at_home.ok();
  const bool origin_only =
      at_home.status == NestStatus::phi_not_observed && at_home.at_body_mm.norm() <= kAtOrigin_mm;
  if (!turns && !origin_only) {
    throw InputError({.what = "the home pose was not measured: there is nothing to zero to",
                      .got = name_of(at_home.status),
                      .expected = "two or three nests, or one at the platform's origin"});
  }
  const double turn_rad = turns ? home.phi_rad - at_home.pose.phi_rad : 0;
  const Eigen::Vector2d seen =
      Eigen::Rotation2Dd(turn_rad) * Eigen::Vector2d(at_home.pose.x_mm, at_home.pose.y_mm);
  const Pose move{home.x_mm - seen.x(), home.y_mm - seen.y(), turn_rad};
  return planar_move(move, -at_home.quality.height_mm) * T_B_T;
}

BaseDrift base_drift(const std::vector<NestPoint>& before, const std::vector<NestPoint>& now,
                     const Eigen::Isometry3d& T_B_T, double sigma_mm, double false_alarm) {
  const InCommon both = in_common(before, now);
  if (both.names.empty()) {
    throw InputError({.what = "no base nest was measured both times",
                      .where = {.field = "base"},
                      .expected = "the nests the frame was registered by"});
  }
  BaseDrift drift;
  drift.n_nests = static_cast<int>(both.names.size());
  drift.limit_mm = sigma_mm * std::sqrt(2 * chi2_limit(false_alarm / drift.n_nests, 3));
  std::vector<Eigen::Vector2d> was, is;
  for (Eigen::Index k = 0; k < both.first.cols(); ++k) {
    const double moved_mm = (both.second.col(k) - both.first.col(k)).norm();
    was.emplace_back((T_B_T * both.first.col(k)).head<2>());
    is.emplace_back((T_B_T * both.second.col(k)).head<2>());
    if (k > 0 && moved_mm <= drift.largest_mm) continue;
    drift.largest_mm = moved_mm;
    drift.nest = both.names[static_cast<std::size_t>(k)];
  }
  drift.moved = drift.largest_mm > drift.limit_mm;
  const PlanarFit fit = fit_planar(was, is);
  drift.shift = {fit.shift_mm.x(), fit.shift_mm.y(), fit.turn_rad};
  return drift;
}

}  // namespace trammel
