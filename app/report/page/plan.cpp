// The mechanism to scale, its workspace, and where was measured.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/report/page/source.hpp"
#include "core/judge/deviation.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/mechanism/workspace.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

constexpr double kHalfWidth_mm = 420;  // of the workspace picture: beyond it no grid of ours goes
constexpr double kCell_mm = 20;
constexpr int kCells = 20;  // of other machines, from the middle to the border

Json place(const Eigen::Vector2d& p) { return Json::array({drawn(p.x()), drawn(p.y())}); }

Eigen::Vector2d along(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

/// One chain at a pose, to be drawn: where its slider can be, where that is, and the joint or point
/// of the platform that it holds.
struct DrawnChain {
  Eigen::Vector2d from, to, slider, joint;
};

/// Of a PRR its rail and link. Of a PPR the drive's line through where the platform stands at home
/// (its place says nothing), and the passive guide. Of an RPR the cylinder's shortest and longest.
DrawnChain drawn_chain(const Machine& machine, std::size_t chain, const Pose& pose, double l_mm) {
  const ChainValues& p = machine.chains[chain];
  const Limits& limits = machine.drives[chain].limits;
  const auto joint_at = [&](const Pose& X, double r, double beta) -> Eigen::Vector2d {
    return Eigen::Vector2d(X.x_mm, X.y_mm) + r * along(beta + X.phi_rad);
  };
  if (machine.kind->chain == &kPrrChain) {
    const auto& [alpha, beta, r, S, l_zero, R, h] = p;
    const Eigen::Vector2d u = along(alpha), n(-u.y(), u.x());
    const auto slider = [&](double l) -> Eigen::Vector2d { return (l + l_zero - R) * u + h * n; };
    return {slider(limits.l_min_mm), slider(limits.l_max_mm), slider(l_mm),
            joint_at(pose, r, beta)};
  }
  if (machine.kind->chain == &kPprChain) {
    const auto& [alpha, gamma, l_zero, c, r, beta, none] = p;
    const Eigen::Vector2d home = joint_at(machine.home, r, beta);
    const double l_home_mm = drives_of(machine, machine.home)[static_cast<Eigen::Index>(chain)];
    const auto slider = [&](double l) -> Eigen::Vector2d {
      return home + (l - l_home_mm) * along(alpha);
    };
    return {slider(limits.l_min_mm), slider(limits.l_max_mm), slider(l_mm),
            joint_at(pose, r, beta)};
  }
  const auto& [Ax, Ay, l_zero, r, beta, none, neither] = p;
  const Eigen::Vector2d base(Ax, Ay), joint = joint_at(pose, r, beta);
  const Eigen::Vector2d u = (joint - base).normalized();
  return {base + (limits.l_min_mm + l_zero) * u, base + (limits.l_max_mm + l_zero) * u, base,
          joint};
}

Json chains_json(const Machine& machine, const Pose& pose, const InverseResult& at) {
  Json chains = Json::array();
  for (std::size_t i = 0; i < static_cast<std::size_t>(machine.kind->n_chains); ++i) {
    const DrawnChain c = drawn_chain(machine, i, pose, at.l_mm[static_cast<Eigen::Index>(i)]);
    chains.push_back({{"rail", Json::array({place(c.from), place(c.to)})},
                      {"slider", place(c.slider)},
                      {"joint", place(c.joint)}});
  }
  return chains;
}

/// Half width and step of the workspace picture: the paper's robot as ever, others by their stroke
/// (a cylinder's is about the middle).
WorkspaceGrid grid_of(const Machine& machine) {
  if (machine.kind->chain == &kPrrChain)
    return {.half_width_mm = kHalfWidth_mm, .step_mm = kCell_mm};
  double half = 0;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    const Limits& l = machine.drives[static_cast<std::size_t>(i)].limits;
    half = std::max(half, machine.kind->chain == &kRprChain
                              ? (l.l_max_mm - l.l_min_mm) / 2
                              : std::max(std::abs(l.l_min_mm), std::abs(l.l_max_mm)));
  }
  return {.half_width_mm = half, .step_mm = half / kCells};
}

/// Where the platform can be at phi = 0: half the distance to the nearest limit, in cells.
Json reach_json(const Machine& machine, const WorkspaceGrid& grid) {
  Json cells = Json::array();
  if (machine.kind->n_chains < 2) return cells;  // an axis has a line, which is drawn
  for (const WorkspaceCell& cell : workspace(machine, grid)) {
    if (!cell.reach.ok()) continue;
    cells.push_back(Json::array(
        {drawn(cell.pose.x_mm), drawn(cell.pose.y_mm), drawn(cell.reach.singularity.margin())}));
  }
  return cells;
}

/// "(1.000, 2.000) mm"
std::string drives_words(const Machine& machine, const InverseResult& at) {
  std::string text;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    text += fmt::format("{}{:.3f}", text.empty() ? "" : ", ", at.l_mm[i]);
  }
  return "(" + text + ") mm";
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
  words = fmt::format("at the target with the largest error before, {:.{}f} mm", error(*worst),
                      decimals(source, Figure::position_mm));
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

/// The machine to scale.
Json mechanism_item(const Source& source) {
  const Machine& machine = source.measured.campaign.machine;
  const MachineSolver solver(machine);
  std::string where;
  Pose pose = chosen_pose(source, where);
  InverseResult at = solver.drives(pose);
  if (!at.ok()) {
    pose = machine.home;
    where = "where the stage was zeroed";
    at = solver.drives(pose);
  }
  if (!at.ok()) {
    return absent("mechanism", "The mechanism to scale",
                  "Neither a target nor the home pose is in the nominal reach.");
  }
  const WorkspaceGrid grid = grid_of(machine);
  const Json reach = reach_json(machine, grid);
  return figure(
      {"mechanism", "The mechanism to scale",
       fmt::format("{}. Drawn with nominal parameters at ({:g}, {:g}) mm, {:g} deg, {}: l = {}.{}",
                   source.report.mechanism, drawn(pose.x_mm), drawn(pose.y_mm),
                   drawn(deg_from_rad(pose.phi_rad)), where, drives_words(machine, at),
                   reach.empty() ? ""
                                 : fmt::format(" Shaded: where the platform centre can be at phi = "
                                               "0 (cells of {:g} mm), darker where farther from "
                                               "singular.",
                                               grid.step_mm))},
      "mechanism",
      {{"pose", Json::array({drawn(pose.x_mm), drawn(pose.y_mm)})},
       {"chains", chains_json(machine, pose, at)},
       {"reach", reach},
       {"cell_mm", grid.step_mm}});
}

}  // namespace

Json plan_section(const Source& source) {
  Json items = Json::array();
  items.push_back(mechanism_item(source));
  const Json targets = targets_json(source);
  items.push_back(targets.empty()
                      ? absent("plan", "Where was measured", "There are no baseline readings yet.")
                      : figure({"plan", "Where was measured",
                                "Targets of all readings without compensation [mm]."},
                               "plan", {{"sets", targets}}));
  return section("plan", "Plan and workspace", items);
}

}  // namespace trammel::report
