#include "core/mechanism/workspace.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"

namespace trammel {

const char* name_of(Reach::Status status) {
  switch (status) {
    case Reach::Status::ok:
      return "ok";
    case Reach::Status::not_finite:
      return "not finite";
    case Reach::Status::unreachable:
      return "unreachable";
    case Reach::Status::limit:
      return "limit";
  }
  return "";
}

Reach reach(const Mechanism& mechanism, const Pose& pose) {
  Reach result;
  if (!pose.vector().allFinite()) return result;
  result.at = inverse(mechanism.geometry, pose);
  if (!result.at.ok()) {
    result.status = Reach::Status::unreachable;
    result.chain = result.at.chain;
    return result;
  }
  const Eigen::Array3d l = result.at.l_mm.array();
  const Eigen::Array3d left = (l - mechanism.limits.l_min_mm).min(mechanism.limits.l_max_mm - l);
  result.stroke_left_mm = left.minCoeff(&result.chain);
  result.singularity =
      singularity(mechanism.geometry, velocity_equation(mechanism.geometry, pose, result.at));
  result.status = result.stroke_left_mm >= 0 ? Reach::Status::ok : Reach::Status::limit;
  return result;
}

std::vector<WorkspaceCell> workspace(const Mechanism& mechanism, const WorkspaceGrid& grid) {
  const double n = std::floor(grid.half_width_mm / grid.step_mm + 1e-9);
  const double cells = (2 * n + 1) * (2 * n + 1);
  const bool usable = std::isfinite(grid.phi_rad) && grid.step_mm > 0 && grid.half_width_mm >= 0;
  if (!usable || !(cells <= kMaxWorkspaceCells)) {
    throw InputError({.what = "the workspace grid is not usable",
                      .got = "half width " + std::to_string(grid.half_width_mm) + " mm, step " +
                             std::to_string(grid.step_mm) + " mm",
                      .expected = "finite numbers, a positive step, at most 4 million cells"});
  }
  const int count = static_cast<int>(n);
  std::vector<WorkspaceCell> map;
  map.reserve(static_cast<std::size_t>(cells));
  for (int row = -count; row <= count; ++row) {
    for (int column = -count; column <= count; ++column) {
      const Pose pose{column * grid.step_mm, row * grid.step_mm, grid.phi_rad};
      map.push_back({pose, reach(mechanism, pose)});
    }
  }
  return map;
}

}  // namespace trammel
