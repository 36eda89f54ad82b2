#include "core/mechanism/workspace.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"

namespace trammel {

std::vector<Pose> grid_poses(const Machine& machine, const WorkspaceGrid& grid) {
  const bool line = machine.kind->n_chains == 1;
  const double n = std::floor(grid.half_width_mm / grid.step_mm + 1e-9);
  const double cells = (2 * n + 1) * (line ? 1 : 2 * n + 1);
  const bool usable = std::isfinite(grid.phi_rad) && grid.step_mm > 0 && grid.half_width_mm >= 0;
  if (!usable || !(cells <= kMaxWorkspaceCells)) {
    throw InputError({.what = "the workspace grid is not usable",
                      .got = "half width " + std::to_string(grid.half_width_mm) + " mm, step " +
                             std::to_string(grid.step_mm) + " mm",
                      .expected = "finite numbers, a positive step, at most 4 million cells"});
  }
  const int count = static_cast<int>(n), rows = line ? 0 : count;
  const double phi_rad = machine.kind->has_point_platform() ? machine.home.phi_rad : grid.phi_rad;
  std::vector<Pose> poses;
  poses.reserve(static_cast<std::size_t>(cells));
  for (int row = -rows; row <= rows; ++row) {
    for (int column = -count; column <= count; ++column) {
      poses.push_back({machine.home.x_mm + column * grid.step_mm,
                       machine.home.y_mm + row * grid.step_mm, phi_rad});
    }
  }
  return poses;
}

std::vector<WorkspaceCell> workspace(const Machine& machine, const WorkspaceGrid& grid) {
  std::vector<WorkspaceCell> map;
  for (const Pose& pose : grid_poses(machine, grid)) map.push_back({pose, reach(machine, pose)});
  return map;
}

}  // namespace trammel
