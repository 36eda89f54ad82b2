#include "app/files/points_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "app/files/points_rows.hpp"
#include "core/error.hpp"
#include "core/measure/point_outliers.hpp"
#include "core/measure/screen.hpp"
#include "core/statistics/robust.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kSameMm = 1e-6;  // a target at home
constexpr double kMostOfBaseMm = 1;
constexpr double kSigmaOfMad = 1.482602;  // of normal noise
constexpr OutlierRule kPoseRule = {.times = 10, .least_mm = 1, .least_n = 5};

class PoseFinder {
 public:
  PoseFinder(const PointsFile& file, const Layout& layout, const Pose& home, const Plan& plan)
      : file_(file),
        layout_(layout),
        home_(home),
        plan_(plan),
        assigned_(assign_rows(file, layout, plan)) {}

  PointsPoses found() {
    find_outliers();
    take_poses();
    register_frames();
    see_poses();
    require_body();
    drop_poses_not_ok();
    drop_far_poses();
    std::sort(
        out_.dropped.begin(), out_.dropped.end(),
        [](const DroppedRow& a, const DroppedRow& b) { return a.lines.front() < b.lines.front(); });
    return std::move(out_);
  }

 private:
  void drop(const PointRow& row, const std::string& why) {
    if (dropped_.insert(&row).second) out_.dropped.push_back({{row.line}, why});
  }

  /// Misses; and points far from the others of their nest and pose, over all repeats.
  void find_outliers() {
    for (const PointRow& row : file_.rows) {
      if (row.miss) drop(row, fmt::format("miss ({})", name_of(*row.miss)));
    }
    std::map<std::pair<int, std::string>, std::vector<const PointRow*>> places;
    for (const PoseRows& pose : assigned_.poses) {
      for (const auto& [nest, rows] : pose.rows) {
        auto& place = places[{pose.pose, nest}];
        place.insert(place.end(), rows.begin(), rows.end());
      }
    }
    for (const BaseRows& visit : assigned_.base) {
      for (const auto& [nest, rows] : visit.rows) {
        auto& place = places[{0, nest}];
        place.insert(place.end(), rows.begin(), rows.end());
      }
    }
    for (auto& [key, rows] : places) {
      std::erase_if(rows, [](const PointRow* row) { return row->miss.has_value(); });
      std::vector<Eigen::Vector3d> points;
      for (const PointRow* row : rows) points.push_back(row->at_mm);
      const Screened screened = screen(points);
      for (const std::size_t k : screened.outliers) {
        drop(*rows[k],
             fmt::format("gross outlier: {:.3f} mm from the median of its place, limit {:.3f}",
                         (points[k] - screened.median_mm).norm(), *screened.limit_mm));
      }
    }
  }

  /// The mean of the rows that are left, by nest.
  std::vector<NestPoint> means(const RowsOfNest& of_nest,
                               std::vector<const PointRow*>* used) const {
    std::vector<NestPoint> points;
    for (const auto& [nest, rows] : of_nest) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double n = 0;
      for (const PointRow* row : rows) {
        if (dropped_.contains(row)) continue;
        sum += row->at_mm;
        n += 1;
        if (used != nullptr) used->push_back(row);
      }
      if (n > 0) points.push_back({nest, sum / n});
    }
    return points;
  }

  void take_poses() {
    for (const PoseRows& rows : assigned_.poses) {
      PointsPose s{.pose = rows.pose, .repeat = rows.repeat};
      s.points = means(rows.rows, &s.used);
      for (const auto& [nest, all] : rows.rows) {
        for (const PointRow* row : all) s.lines.push_back(row->line);
      }
      std::sort(s.lines.begin(), s.lines.end());
      std::sort(s.used.begin(), s.used.end(),
                [](const PointRow* a, const PointRow* b) { return a->line < b->line; });
      out_.poses.push_back(std::move(s));
    }
  }

  /// Frames by epoch, and the epoch of each standing.
  void register_frames() {
    switch (layout_.frame.from) {
      case FrameFrom::robot:
        frames_ = {Eigen::Isometry3d::Identity()};
        break;
      case FrameFrom::base_nests:
        register_base();
        break;
      case FrameFrom::zeroing:
        zero();
        break;
    }
  }

  void register_base() {
    std::vector<NestPoint> registered;
    for (std::size_t k = 0; k < assigned_.base.size(); ++k) {
      const BaseRows& visit = assigned_.base[k];
      const std::vector<NestPoint> measured = means(visit.rows, nullptr);
      if (k == 0) {
        out_.base = frame_of_base(measured, layout_.frame.base);
        require_base();
        frames_ = {out_.base.T_B_T};
        registered = measured;
        continue;
      }
      if (measured.empty()) continue;  // each of its rows is named as missed
      DriftSeen seen{.line = visit.rows.begin()->second.front()->line,
                     .drift = base_drift(registered, measured, frames_.back(), layout_.sigma_mm,
                                         layout_.frame.false_alarm)};
      if (seen.drift.moved && measured.size() >= 3) {
        const BaseFrame again = frame_of_base(measured, layout_.frame.base);
        if (again.max_mm > out_.base.max_mm + seen.drift.limit_mm) {
          drop_visit(visit, again);
          continue;
        }
        frames_.push_back(again.T_B_T);
        registered = measured;
        for (std::size_t later = visit.before; later < out_.poses.size(); ++later) {
          ++out_.poses[later].epoch;
        }
      }
      seen.epoch = static_cast<int>(frames_.size());
      out_.drifts.push_back(seen);
    }
    if (frames_.empty())
      refuse_points(file_, "the base nests were not measured", "0 visits", "one at least");
  }

  /// Base nests as drawn may be off by tenths; more is another nest, or another unit.
  void require_base() const {
    if (out_.base.max_mm <= std::max(kMostOfBaseMm, 20 * layout_.sigma_mm)) return;
    refuse_points(
        file_, "the base nests do not stand as the layout says",
        fmt::format("{} off by {:.3f} mm after the best fit", out_.base.worst, out_.base.max_mm),
        fmt::format("{} mm or less", kMostOfBaseMm), "two of them swapped, or another unit?");
  }

  /// Nests that have moved against one another register nothing.
  void drop_visit(const BaseRows& visit, const BaseFrame& fit) {
    DroppedRow row;
    for (const auto& [nest, rows] : visit.rows) {
      for (const PointRow* at : rows) row.lines.push_back(at->line);
    }
    std::sort(row.lines.begin(), row.lines.end());
    row.why = fmt::format("base nests no longer fit one another: {} off by {:.3f} mm", fit.worst,
                          fit.max_mm);
    out_.dropped.push_back(row);
  }

  void zero() {
    std::vector<NestPoint> all;
    for (const PointsPose& s : out_.poses) all.insert(all.end(), s.points.begin(), s.points.end());
    NestFrame frame = layout_.body;
    frame.T_B_T = frame_on_plane(motion_plane(all), layout_.frame.up);
    for (const PointsPose& s : out_.poses) {
      const Eigen::Vector3d off = planned(plan_, s).target.vector() - home_.vector();
      if (off.cwiseAbs().maxCoeff() > kSameMm) continue;
      const NestPose at_home = pose_of_nests(s.points, frame, layout_.sigma_mm);
      if (!at_home.ok()) continue;
      frames_ = {zeroed(frame.T_B_T, at_home, home_)};
      return;
    }
    refuse_points(file_, "no pose at home was measured: there is nothing to zero to",
                  "none of the measured poses was planned there",
                  "a planned point at home whose nests fit the body",
                  "wrong side of the plane? see frame.up");
  }

  void see_poses() {
    NestFrame frame = layout_.body;
    for (PointsPose& s : out_.poses) {
      frame.T_B_T = frames_[static_cast<std::size_t>(s.epoch) - 1];
      s.seen = pose_of_nests(s.points, frame, layout_.sigma_mm);
      double& phi = s.seen.pose.phi_rad;
      phi = near_target_rad(phi, planned(plan_, s).target.phi_rad);
    }
    see_sides();
  }

  void see_sides() {
    const auto& body = layout_.body.body;
    for (std::size_t i = 0; i < body.size(); ++i) {
      for (std::size_t j = i + 1; j < body.size(); ++j) {
        std::vector<double> off_mm;
        for (const PointsPose& s : out_.poses) {
          const auto a = point_of(s, body[i].nest), b = point_of(s, body[j].nest);
          if (a && b) off_mm.push_back((*a - *b).norm() - (body[i].at_mm - body[j].at_mm).norm());
        }
        if (off_mm.empty()) continue;
        const double middle = median(off_mm);
        std::vector<double> away_mm;
        for (const double off : off_mm) away_mm.push_back(std::abs(off - middle));
        out_.sides.push_back(
            {body[i].nest + "-" + body[j].nest, middle, kSigmaOfMad * median(away_mm)});
      }
    }
  }

  static std::optional<Eigen::Vector3d> point_of(const PointsPose& s, const std::string& nest) {
    for (const NestPoint& p : s.points) {
      if (p.nest == nest) return p.at_mm;
    }
    return std::nullopt;
  }

  /// A body that most poses contradict is not the platform that was measured.
  void require_body() const {
    int judged = 0, mirrored = 0, bent = 0;
    for (const PointsPose& s : out_.poses) {
      judged += s.seen.ok() ? 1 : 0;
      mirrored += s.seen.status == NestStatus::mirrored ? 1 : 0;
      bent += s.seen.status == NestStatus::not_rigid ? 1 : 0;
    }
    judged += mirrored + bent;
    if (2 * mirrored > judged) {
      refuse_points(file_, "the nests stand as in a mirror",
                    fmt::format("{} of {} poses", mirrored, judged), "the platform of the layout",
                    "two nests swapped, or frame.up on the wrong side?");
    }
    if (2 * bent <= judged) return;
    std::string sides;
    for (const SideSeen& side : out_.sides) {
      sides += fmt::format("{}{} {:+.4f} mm (scatter {:.4f})", sides.empty() ? "" : ", ", side.side,
                           side.off_mm, side.scatter_mm);
    }
    refuse_points(file_, "the nests do not stand as the layout says",
                  fmt::format("{} of {} poses; sides, measured - layout: {}", bent, judged, sides),
                  fmt::format("sides within the noise of sigma_mm {} and u_nest_mm {}",
                              layout_.sigma_mm, layout_.body.u_nest_mm),
                  "are the unit, the nests' places and sigma_mm right?");
  }

  [[nodiscard]] double off_target_mm(const PointsPose& s) const {
    return (s.seen.pose.vector() - planned(plan_, s).target.vector()).head<2>().norm();
  }

  void drop_far_poses() {
    std::vector<double> off_mm;
    for (const PointsPose& s : out_.poses) {
      if (s.seen.ok()) off_mm.push_back(off_target_mm(s));
    }
    if (static_cast<int>(off_mm.size()) < kPoseRule.least_n) return;
    const double limit_mm = std::max(kPoseRule.times * median(off_mm), kPoseRule.least_mm);
    for (PointsPose& s : out_.poses) {
      if (!s.seen.ok() || off_target_mm(s) <= limit_mm) continue;
      out_.dropped.push_back(
          {s.lines, fmt::format("pose {}: {:.3f} mm from its target, limit {:.3f}", s.pose,
                                off_target_mm(s), limit_mm)});
      s.seen.status = NestStatus::no_nests;
    }
  }

  /// The poses that make no reading, with the reason; far ones are said already.
  void drop_poses_not_ok() {
    for (const PointsPose& s : out_.poses) {
      if (s.seen.ok()) continue;
      out_.dropped.push_back({s.lines, words_of(s)});
    }
  }

  [[nodiscard]] std::string words_of(const PointsPose& s) const {
    const NestQuality& q = s.seen.quality;
    std::string why =
        fmt::format("pose {}, repeat {}: {}", s.pose, s.repeat, name_of(s.seen.status));
    if (s.seen.status == NestStatus::not_rigid) {
      why += fmt::format(", side {} off by {:+.4f} mm, limit {:.4f}", q.side, q.side_mm,
                         q.side_limit_mm);
    } else if (s.seen.status == NestStatus::phi_not_observed) {
      why += fmt::format(": {} of {} nests", s.seen.n_nests, layout_.body.body.size());
    }
    return why;
  }

  const PointsFile& file_;
  const Layout& layout_;
  const Pose& home_;
  const Plan& plan_;
  const AssignedRows assigned_;
  std::set<const PointRow*> dropped_;
  std::vector<Eigen::Isometry3d> frames_;  // T_B_T by epoch
  PointsPoses out_;
};

}  // namespace

const PlannedPoint& planned(const Plan& plan, const PointsPose& pose) {
  return plan.points[static_cast<std::size_t>(pose.pose) - 1];
}

PointsPoses poses_of_points(const PointsFile& file, const Layout& layout, const Pose& home,
                            const Plan& plan) {
  return PoseFinder(file, layout, home, plan).found();
}

}  // namespace trammel
