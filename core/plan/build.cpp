#include "core/plan/build.hpp"

#include <algorithm>
#include <string>

#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/statistics/random.hpp"

namespace trammel {

namespace {

constexpr std::size_t kMaxPlanned = 1000000;  // points: a year of measuring

void require_sensible(const PlanRequest& request) {
  std::size_t poses = 0;
  for (const TargetGroup& group : request.groups) poses += group.poses.size();
  const std::size_t per_round = poses * request.orientations_rad.size() * request.approaches.size();
  if (per_round == 0) {
    throw InputError({.what = "the plan has no points",
                      .expected = "at least one pose, one orientation and one direction"});
  }
  if (request.repeats < 1 || per_round > kMaxPlanned / static_cast<std::size_t>(request.repeats)) {
    throw InputError({.what = "the plan is not usable",
                      .where = {.field = "repeats"},
                      .got = std::to_string(request.repeats),
                      .expected = "1 or more, and at most a million points in all"});
  }
}

std::vector<Pose> turned(std::vector<Pose> poses, double phi_rad) {
  for (Pose& pose : poses) pose.phi_rad += phi_rad;
  return poses;
}

}  // namespace

Plan build_plan(const PlanRequest& request) {
  require_sensible(request);
  Plan plan{request.name, request.approach_mm, {}};
  Pose at;
  std::uint64_t block = 0;
  for (int repeat = 1; repeat <= request.repeats; ++repeat) {
    for (const double phi : request.orientations_rad) {
      for (const Approach& approach : request.approaches) {
        for (const TargetGroup& group : request.groups) {
          const std::uint64_t seed = mix(request.seed, "plan", block++);
          for (const Pose& pose : ordered(turned(group.poses, phi), request.order, seed, at)) {
            plan.points.push_back({.target = pose,
                                   .set = request.set,
                                   .approach = approach,
                                   .repeat = repeat,
                                   .group = group.name});
            at = pose;
          }
        }
      }
    }
  }
  int seq = 0;
  for (PlannedPoint& point : plan.points) {
    point.seq = ++seq;
    point.reference = seq <= request.references;
  }
  validate(plan);
  return plan;
}

Plan rail_plan(const Machine& machine, const RailRequest& request) {
  if (!(request.half_travel_mm > 0) || request.targets < 2 || request.targets > 10000 ||
      request.runs < 1 || request.runs > 1000) {
    throw InputError({.what = "the rail plan is not usable",
                      .expected = "a positive travel, 2 to 10000 targets, 1 to 1000 runs"});
  }
  const MachineSolver solver(machine);
  const InverseResult home = solver.drives(machine.home);
  if (!home.ok()) throw InputError({.what = "the home pose is out of reach"});
  Plan plan{request.name, request.approach_mm, {}};
  for (int rail = 0; rail < machine.kind->n_chains; ++rail) {
    std::vector<Pose> poses;
    for (int k = 0; k < request.targets; ++k) {
      Displacements l = home.l_mm;
      l[rail] += request.half_travel_mm * (2.0 * k / (request.targets - 1) - 1);
      const MachinePose at = solver.pose(l, machine.home);
      if (!at.ok()) {
        throw InputError({.what = "a target of the rail plan is out of reach",
                          .where = {.field = "rail " + std::to_string(rail + 1)},
                          .got = "l = " + std::to_string(l[rail]) + " mm"});
      }
      poses.push_back(at.pose);
    }
    for (int run = 1; run <= request.runs; ++run) {
      for (const int direction : {1, -1}) {
        Approach approach = {0, 0, 0};
        approach[static_cast<std::size_t>(rail)] = direction;
        for (const Pose& pose : poses) {
          plan.points.push_back({.seq = static_cast<int>(plan.points.size()) + 1,
                                 .target = pose,
                                 .approach = approach,
                                 .repeat = run,
                                 .group = "rail " + std::to_string(rail + 1)});
        }
        std::reverse(poses.begin(), poses.end());
      }
    }
  }
  validate(plan);
  return plan;
}

}  // namespace trammel
