// The mechanism to scale, its workspace, and where was measured.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/report/page/source.hpp"
#include "core/judge/deviation.hpp"
#include "core/mechanism/workspace.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

constexpr double kHalfWidth_mm = 420;  // of the workspace picture: beyond it no grid of ours goes
constexpr double kCell_mm = 20;

Json place(const Eigen::Vector2d& p) { return Json::array({drawn(p.x()), drawn(p.y())}); }

Eigen::Vector2d along(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

/// Rail (where its slider can be), slider B, platform joint C of each chain at a pose.
Json mechanism_json(const Mechanism& mechanism, const Pose& pose, const InverseResult& at) {
  Json chains = Json::array();
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = mechanism.geometry.chains[static_cast<std::size_t>(i)];
    const Eigen::Vector2d u = along(c.alpha_rad), n(-u.y(), u.x());
    const auto slider = [&](double l) -> Eigen::Vector2d {
      return (l + c.l_zero_mm - c.R_mm) * u + c.h_mm * n;
    };
    const Eigen::Vector2d joint =
        Eigen::Vector2d(pose.x_mm, pose.y_mm) + c.r_mm * along(c.beta_rad + pose.phi_rad);
    chains.push_back({{"rail", Json::array({place(slider(mechanism.limits.l_min_mm)),
                                            place(slider(mechanism.limits.l_max_mm))})},
                      {"slider", place(slider(at.l_mm[i]))},
                      {"joint", place(joint)}});
  }
  return chains;
}

/// Where the platform can be at phi = 0: half the distance to the nearest limit, in cells.
Json reach_json(const Mechanism& mechanism) {
  Json cells = Json::array();
  for (const WorkspaceCell& cell :
       workspace(machine_of(mechanism), {.half_width_mm = kHalfWidth_mm, .step_mm = kCell_mm})) {
    if (!cell.reach.ok()) continue;
    cells.push_back(Json::array(
        {drawn(cell.pose.x_mm), drawn(cell.pose.y_mm), drawn(cell.reach.singularity.margin())}));
  }
  return cells;
}

/// The pose of the largest error before, else where the stage was zeroed.
Pose chosen_pose(const Source& source, std::string& words) {
  const Visit* worst = nullptr;
  const auto error = [](const Visit& v) {
    return position_error_mm(*v.reading.measured, v.reading.target);
  };
  for (const Walk& walk : source.measured.walks) {
    if (walk.session.compensated()) continue;
    for (const Visit& v : walk.visits) {
      if (worst == nullptr || error(v) > error(*worst)) worst = &v;
    }
  }
  if (worst == nullptr) {
    words = "where the stage was zeroed";
    return source.measured.campaign.machine.home;
  }
  words = fmt::format("at the target with the largest error before, {:.4f} mm", error(*worst));
  return worst->reading.target;
}

struct TargetSet {
  const char* name;
  bool (*holds)(const Visit& visit);
};
constexpr TargetSet kSets[] = {
    {"identify (may be fitted)",
     [](const Visit& v) { return v.reading.set == ReadingSet::identify && !on_circle(v); }},
    {"validate (never fitted)",
     [](const Visit& v) { return v.reading.set == ReadingSet::validate && !on_circle(v); }},
    {"circles", on_circle}};

Json targets_json(const Source& source) {
  Json sets = Json::array();
  for (const TargetSet& set : kSets) {
    Json points = Json::array();
    for (const Walk& walk : source.measured.walks) {
      if (walk.session.compensated()) continue;
      for (const Visit& v : walk.visits) {
        if (!set.holds(v)) continue;
        points.push_back(Json::array({drawn(v.reading.target.x_mm), drawn(v.reading.target.y_mm),
                                      drawn(deg_from_rad(v.reading.target.phi_rad)), v.point}));
      }
    }
    if (!points.empty()) sets.push_back({{"name", set.name}, {"points", points}});
  }
  return sets;
}

}  // namespace

Json plan_section(const Source& source) {
  const Mechanism& mechanism = mechanism_of(source.measured.campaign.machine);
  std::string where;
  Pose pose = chosen_pose(source, where);
  InverseResult at = inverse(mechanism.geometry, pose);
  if (!at.ok()) {
    pose = mechanism.home;
    where = "where the stage was zeroed";
    at = inverse(mechanism.geometry, pose);
  }
  Json items = Json::array();
  if (at.ok()) {
    items.push_back(figure(
        {"mechanism", "The mechanism to scale",
         fmt::format("{}. Drawn with nominal parameters at ({:g}, {:g}) mm, {:g} deg, {}: l = "
                     "({:.3f}, {:.3f}, {:.3f}) mm. Shaded: where the platform centre can be at "
                     "phi = 0 (cells of {:g} mm), darker where farther from singular.",
                     source.report.mechanism, drawn(pose.x_mm), drawn(pose.y_mm),
                     drawn(deg_from_rad(pose.phi_rad)), where, at.l_mm[0], at.l_mm[1], at.l_mm[2],
                     kCell_mm)},
        "mechanism",
        {{"pose", Json::array({drawn(pose.x_mm), drawn(pose.y_mm)})},
         {"chains", mechanism_json(mechanism, pose, at)},
         {"reach", reach_json(mechanism)},
         {"cell_mm", kCell_mm}}));
  } else {
    items.push_back(absent("mechanism", "The mechanism to scale",
                           "Neither a target nor the home pose is in the nominal reach."));
  }
  const Json targets = targets_json(source);
  items.push_back(targets.empty()
                      ? absent("plan", "Where was measured", "There are no baseline readings yet.")
                      : figure({"plan", "Where was measured",
                                "Targets of all readings without compensation [mm]."},
                               "plan", {{"sets", targets}}));
  return section("plan", "Plan and workspace", items);
}

}  // namespace trammel::report
