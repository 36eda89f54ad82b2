#pragma once
// What can be reached within the stroke limits, and how far from singular it is.

#include <vector>

#include "core/mechanism/machine_kinematics.hpp"

namespace trammel {

/// A square grid of poses at one orientation, through the origin O_A; of an axis a line of them.
/// It lies about home; phi stands at home's for a machine that does not turn.
struct WorkspaceGrid {
  double half_width_mm = 150;
  double step_mm = 10;
  double phi_rad = 0;
};

/// Every pose of the grid, row by row from the lowest y, x rising. Throws InputError when the grid
/// is not finite, has no width, or more than kMaxWorkspaceCells cells.
std::vector<Pose> grid_poses(const Machine& machine, const WorkspaceGrid& grid);

struct WorkspaceCell {
  Pose pose;
  Reach reach;
};

/// reach() of grid_poses().
/// Proof: symmetry under a turn by 120 deg, limits, margins and assemblies (workspace_test.cpp).
std::vector<WorkspaceCell> workspace(const Machine& machine, const WorkspaceGrid& grid);

inline constexpr double kMaxWorkspaceCells = 4e6;

}  // namespace trammel
