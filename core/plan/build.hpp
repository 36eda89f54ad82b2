#pragma once
// From target poses to a plan: orientations, directions of approach, repeats, order.

#include <cstdint>
#include <string>
#include <vector>

#include "core/mechanism/machine.hpp"
#include "core/plan/grids.hpp"
#include "core/plan/plan.hpp"

namespace trammel {

/// Poses that belong together; the group's name stays with its points.
struct TargetGroup {
  std::string name = {};
  std::vector<Pose> poses;
};

struct PlanRequest {
  std::string name;
  std::vector<TargetGroup> groups = {};
  std::vector<double> orientations_rad = {0};  // added to each pose's own
  std::vector<Approach> approaches = {Approach{0, 0, 0}};
  int repeats = 1;
  ReadingSet set = ReadingSet::identify;
  Order order = Order::as_listed;
  std::uint64_t seed = 1;
  double approach_mm = 5;
  int references = 0;  // the first so many points serve as references after a resume
};

/// Every pose at every orientation, from every direction, `repeats` times. A repeat is a whole
/// round: visit 2 of a point comes when all have had visit 1. Each round, orientation, direction
/// and group is ordered on its own. Throws InputError when nothing is asked for, or too much.
Plan build_plan(const PlanRequest& request);

/// One rail at a time, the others at home, for positional accuracy of an axis (ISO 230-2).
struct RailRequest {
  std::string name = "rail";
  double half_travel_mm = 50;  // targets at home - half_travel … home + half_travel
  int targets = 11;
  int runs = 5;  // each in both directions
  double approach_mm = 5;
};

/// Per rail and run: all targets upwards with direction +1, then downwards with -1; group "rail i",
/// repeat = run. Poses are where the nominal machine stands with one drive displaced. Throws
/// InputError when a target is out of reach, naming rail and displacement.
Plan rail_plan(const Machine& machine, const RailRequest& request);
inline Plan rail_plan(const Mechanism& mechanism, const RailRequest& request) {
  return rail_plan(machine_of(mechanism), request);
}

}  // namespace trammel
