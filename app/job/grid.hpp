#pragma once
// A grid of points as it is asked for: by the options of `plan create`, by a step of a protocol.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/files/fields.hpp"
#include "core/calibrate/optimal_plan.hpp"
#include "core/plan/build.hpp"
#include "core/units.hpp"

namespace trammel::job {

struct GridRequest {
  std::string grid;       // a name of grids()
  std::string name = {};  // of the plan; empty: the grid's
  std::optional<double> step_mm = {};
  int count = 10;
  std::optional<double> half_width_mm = {};  // of the square; none: what holds `hull`, or 100
  std::vector<Place> hull = {};              // points beyond it are left out; none: no bounds
  std::vector<double> centre_mm = {0, 0};
  double radius_mm = 50;
  std::optional<int> points = {};
  std::vector<double> orientations_deg = {};
  std::vector<Approach> approaches = {Approach{0, 0, 0}};
  double approach_mm = 5;
  int repeats = 1;
  Order order = Order::as_listed;
  int seed = 1;
  ReadingSet set = ReadingSet::identify;
  int references = 0;
  double travel_mm = 50;
  int targets = 11;
  int runs = 5;
  Criterion criterion = Criterion::D;
  TrackerSigma sigma = {0.010, rad_from_deg(0.004)};  // of one tracker reading
  std::vector<std::string> effects = {"lead_scale", "backlash"};
};

/// The named grids, then "lattice", "circle", "rail", "optimal".
const std::vector<std::string>& grids();

const std::vector<std::pair<std::string, Order>>& orders();
const std::vector<std::pair<std::string, Criterion>>& criteria();

/// What shapes some grids only: its option of `plan create`, its field in a protocol ("": none).
struct GridField {
  const char* option;
  const char* field;
  std::vector<std::string> grids;
  bool but = false;  // all grids but these

  [[nodiscard]] bool used_by(const std::string& grid) const;
  /// "lattice, optimal"; "a grid other than rail".
  [[nodiscard]] std::string users() const;
};
const std::vector<GridField>& grid_fields();

/// The object "plan" of a protocol's step. Throws InputError: an unknown field, one that does
/// nothing for the grid. Proof: tests/app/protocol/protocol_test.cpp.
GridRequest read_grid(Fields& fields);

struct GridPlan {
  Plan plan;
  std::size_t n_all = 0;  // poses of the grid
  std::size_t n_out = 0;  // that were left out
};

/// The plan of the grid, on the machine: of a lattice an axis visits the line through home. Poses
/// beyond `hull`, and with `only_safe` those that are not safe on the machine at each orientation
/// and from each direction that is asked for, are left out. Throws InputError where none is left.
/// Proof: tests/app/cli/plan_bounds_test.cpp.
GridPlan grid_plan(const GridRequest& request, const Machine& machine, bool only_safe = false);

}  // namespace trammel::job
