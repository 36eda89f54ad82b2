#pragma once
// What can be reached within the stroke limits, and how far from singular it is.

#include <vector>

#include "core/mechanism/geometry.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/mechanism/velocity.hpp"

namespace trammel {

/// One pose against the mechanism's limits.
struct [[nodiscard]] Reach {
  enum class Status { ok, not_finite, unreachable, limit };
  Status status = Status::not_finite;
  int chain = 0;              // unreachable: the chain; else the rail nearest to a limit, from 0
  double stroke_left_mm = 0;  // ok and limit: to the nearest end of that rail; negative beyond it
  InverseResult at = {};      // ok and limit
  Singularity singularity = {};  // ok and limit

  [[nodiscard]] bool ok() const { return status == Status::ok; }
};
Reach reach(const Mechanism& mechanism, const Pose& pose);

/// "ok", "not finite", "unreachable", "limit".
const char* name_of(Reach::Status status);

/// A square grid of poses at one orientation, through the origin O_A.
struct WorkspaceGrid {
  double half_width_mm = 150;
  double step_mm = 10;
  double phi_rad = 0;
};

struct WorkspaceCell {
  Pose pose;
  Reach reach;
};

/// Every pose of the grid, row by row from the lowest y, x rising. Throws InputError when the grid
/// is not finite, has no width, or more than kMaxWorkspaceCells cells.
/// Proof: symmetry under a turn by 120 deg, limits and margins (workspace_test.cpp).
std::vector<WorkspaceCell> workspace(const Mechanism& mechanism, const WorkspaceGrid& grid);

inline constexpr double kMaxWorkspaceCells = 4e6;

}  // namespace trammel
