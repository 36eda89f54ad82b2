#pragma once
// A stage's correction as one table over its plane: what controllers take that correct two axes by
// where both stand.

#include <string>
#include <vector>

#include "app/job/controller_tables.hpp"

namespace trammel::job {

/// Corrections of both axes at the nodes of a square lattice, row by row in y, mean of both
/// directions of approach; between nodes bilinear.
struct PlaneTable {
  double first_mm = 0;  // of x and of y
  double step_mm = 1;
  int side = 0;                                 // nodes along x, and along y
  std::vector<Eigen::Vector2d> values_mm = {};  // (side * side)
  std::array<TableError, 2> before = {}, left = {},
                            grid = {};  // of each axis, as DriveTables has them
  double directions_mm = 0;  // most by which the corrections of the two directions differ

  [[nodiscard]] Eigen::Vector2d at(double x_mm, double y_mm) const;
};

/// Nodes `step_mm` apart over the square of `request`, both drives growing and both falling. Left
/// and grid are judged at the cells' centres, where a bilinear table is farthest from its nodes.
/// Proof: controller_tables_test.cpp.
/// @throws InputError  the machine is no XY stage, a node is out of reach, more than 100,000 nodes
PlaneTable plane_table(const Correction& correction, const NominalMachine& machine,
                       const TableRequest& request, double step_mm);

/// Aerotech: one 2D table, rows along axis 2. General knowledge, tried on no controller.
ControllerFile aerotech_file(const PlaneTable& table, const std::string& name);

std::vector<std::string> table_words(const PlaneTable& table);

}  // namespace trammel::job
