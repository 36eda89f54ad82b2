#include "core/measure/nests.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/error.hpp"
#include "core/plane/rigid.hpp"
#include "core/statistics/limits.hpp"

namespace trammel {

namespace {

/// Measured and stated place of each nest that was measured.
struct Pairs {
  std::vector<NestPoint> body, seen;  // seen: in B
};

[[noreturn]] void refuse_nest(const std::string& what, const std::string& nest) {
  throw InputError({.what = what, .where = {.field = nest}});
}

const NestPoint& place_on_body(const NestFrame& frame, const std::string& nest) {
  const auto at = std::find_if(frame.body.begin(), frame.body.end(),
                               [&nest](const NestPoint& b) { return b.nest == nest; });
  if (at != frame.body.end()) return *at;
  std::string known;
  for (const auto& b : frame.body) known += (known.empty() ? "" : ", ") + b.nest;
  throw InputError({.what = "the body has no such nest",
                    .where = {.field = "nests"},
                    .got = nest,
                    .expected = known});
}

Pairs paired(const std::vector<NestPoint>& measured, const NestFrame& frame) {
  Pairs pairs;
  std::set<std::string> names;
  for (const NestPoint& point : measured) {
    if (!names.insert(point.nest).second) refuse_nest("a nest was measured twice", point.nest);
    if (!point.at_mm.allFinite()) refuse_nest("a measured point is not a number", point.nest);
    pairs.body.push_back(place_on_body(frame, point.nest));
    if (!pairs.body.back().at_mm.allFinite()) {
      refuse_nest("a nest of the body is not a number", point.nest);
    }
    pairs.seen.push_back({point.nest, frame.T_B_T * point.at_mm});
  }
  return pairs;
}

void judge_heights(const Pairs& pairs, NestQuality& quality) {
  const auto n = static_cast<double>(pairs.seen.size());
  const auto over = [&pairs](std::size_t k) {
    return pairs.seen[k].at_mm.z() - pairs.body[k].at_mm.z();
  };
  for (std::size_t k = 0; k < pairs.seen.size(); ++k) quality.height_mm += over(k) / n;
  for (std::size_t k = 0; k < pairs.seen.size(); ++k) {
    quality.out_of_plane_mm =
        std::max(quality.out_of_plane_mm, std::abs(over(k) - quality.height_mm));
  }
}

void judge_sides(const Pairs& pairs, double s_mm, double false_alarm, NestQuality& quality) {
  int sides = 0;
  for (std::size_t i = 0; i < pairs.seen.size(); ++i) {
    for (std::size_t j = i + 1; j < pairs.seen.size(); ++j, ++sides) {
      const double side_mm = (pairs.seen[i].at_mm - pairs.seen[j].at_mm).norm() -
                             (pairs.body[i].at_mm - pairs.body[j].at_mm).norm();
      if (sides > 0 && std::abs(side_mm) <= std::abs(quality.side_mm)) continue;
      quality.side_mm = side_mm;
      quality.side = pairs.seen[i].nest + "-" + pairs.seen[j].nest;
    }
  }
  if (sides > 0) quality.side_limit_mm = normal_limit(false_alarm / sides) * std::sqrt(2.0) * s_mm;
}

NestStatus judged(const PlanarFit& fit, const NestQuality& quality) {
  if (std::abs(quality.side_mm) > quality.side_limit_mm) return NestStatus::not_rigid;
  // Sides can't tell a triangle from its mirror image; the fit can, unless it is a line.
  const bool off = fit.rms_mm > quality.side_limit_mm;
  return off && fit.mirrored_rms_mm < fit.rms_mm ? NestStatus::mirrored : NestStatus::ok;
}

Eigen::Matrix3d covariance_of(const PlanarFit& fit, std::size_t n, double s_mm) {
  const double var_phi = s_mm * s_mm / fit.spread_mm2;
  const Eigen::Vector2d v = Eigen::Rotation2Dd(fit.turn_rad + M_PI / 2) * fit.body_centre_mm;
  Eigen::Matrix3d cov;
  cov.topLeftCorner<2, 2>() = Eigen::Matrix2d::Identity() * (s_mm * s_mm / static_cast<double>(n)) +
                              var_phi * v * v.transpose();
  cov.topRightCorner<2, 1>() = -var_phi * v;
  cov.bottomLeftCorner<1, 2>() = -var_phi * v.transpose();
  cov(2, 2) = var_phi;
  return cov;
}

}  // namespace

const char* name_of(NestStatus status) {
  constexpr std::array<const char*, 5> kNames = {"ok", "phi not observed", "no nests", "mirrored",
                                                 "not rigid"};
  return kNames[static_cast<std::size_t>(status)];
}

NestPose pose_of_nests(const std::vector<NestPoint>& measured, const NestFrame& frame,
                       double sigma_mm) {
  if (!(std::isfinite(sigma_mm) && sigma_mm > 0)) {
    throw InputError({.what = "the tracker's standard deviation of a point is no length",
                      .where = {.field = "sigma_mm"},
                      .got = std::to_string(sigma_mm),
                      .expected = "a positive number"});
  }
  const Pairs pairs = paired(measured, frame);
  NestPose out;
  out.n_nests = static_cast<int>(pairs.seen.size());
  if (pairs.seen.empty()) return out;
  std::vector<Eigen::Vector2d> body, seen;
  for (const auto& b : pairs.body) body.emplace_back(b.at_mm.head<2>());
  for (const auto& m : pairs.seen) seen.emplace_back(m.at_mm.head<2>());
  const PlanarFit fit = fit_planar(body, seen);
  const double s_mm = std::hypot(sigma_mm, frame.u_nest_mm);
  judge_heights(pairs, out.quality);
  judge_sides(pairs, s_mm, frame.false_alarm, out.quality);
  out.quality.rms_mm = fit.rms_mm;
  out.quality.scale = fit.scale;
  // Nests nearer to one another than their own uncertainty show no direction.
  if (fit.spread_mm2 <= s_mm * s_mm) {
    out.status = NestStatus::phi_not_observed;
    out.at_body_mm = fit.body_centre_mm;
    out.pose = {fit.seen_centre_mm.x(), fit.seen_centre_mm.y(), 0};
    out.covariance.topLeftCorner<2, 2>().diagonal().setConstant(s_mm * s_mm / out.n_nests);
    return out;
  }
  out.status = judged(fit, out.quality);
  out.pose = {fit.shift_mm.x(), fit.shift_mm.y(), fit.turn_rad};
  out.covariance = covariance_of(fit, pairs.seen.size(), s_mm);
  return out;
}

}  // namespace trammel
