#include "app/job/plane_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/plan/grids.hpp"

namespace trammel::job {

namespace {

constexpr double kMostNodes = 100'000;

/// The corrections of both axes at a target, arriving with both drives growing or falling.
Eigen::Vector2d correction_at(const Correction& correction, const NominalMachine& machine,
                              const TableRequest& request, double x_mm, double y_mm,
                              int direction) {
  const Pose target{x_mm, y_mm, 0};
  const InverseResult nominal = machine.drives(target);
  InverseResult at;
  if (nominal.ok()) {
    at = commanded(correction, machine,
                   {.target = target,
                    .from_mm = nominal.l_mm,
                    .approach = {direction, direction, 0},
                    .epoch = request.epoch,
                    .time_s = request.time_s,
                    .temp_degc = request.temp_degc});
  }
  if (!at.ok() || !within_limits(machine.machine(), at.l_mm)) {
    throw InputError({.what = "the stage can't go to a node of the table",
                      .where = {.point = fmt::format("x {:g} mm, y {:g} mm", x_mm, y_mm)},
                      .hint = "--half-width-mm takes a smaller square"});
  }
  return (at.l_mm - nominal.l_mm).head<2>();
}

/// Deviations of one axis, added up.
class Sum {
 public:
  void add(double mm) {
    squares_ += mm * mm;
    max_ = std::max(max_, std::abs(mm));
    ++n_;
  }
  [[nodiscard]] TableError error() const { return {std::sqrt(squares_ / std::max(n_, 1)), max_}; }

 private:
  double squares_ = 0, max_ = 0;
  int n_ = 0;
};

}  // namespace

Eigen::Vector2d PlaneTable::at(double x_mm, double y_mm) const {
  const auto cell = [this](double mm) {
    const double at = (mm - first_mm) / step_mm;
    const int low = std::clamp(static_cast<int>(std::floor(at)), 0, side - 2);
    return std::pair{low, std::clamp(at - low, 0.0, 1.0)};
  };
  const auto [i, u] = cell(x_mm);
  const auto [j, v] = cell(y_mm);
  const auto node = [&](int column, int row) -> const Eigen::Vector2d& {
    return values_mm[static_cast<std::size_t>(row * side + column)];
  };
  return (1 - v) * ((1 - u) * node(i, j) + u * node(i + 1, j)) +
         v * ((1 - u) * node(i, j + 1) + u * node(i + 1, j + 1));
}

PlaneTable plane_table(const Correction& correction, const NominalMachine& machine,
                       const TableRequest& request, double step_mm) {
  const MachineKind& kind = *machine.machine().kind;
  if (!kind.has_point_platform() || kind.n_chains != 2) {
    throw InputError({.what = "a table over the plane corrects the two axes of an XY stage",
                      .got = "a machine of kind " + std::string(kind.name),
                      .hint = "--format aerotech writes a table for each drive"});
  }
  PlaneTable table{.step_mm = step_mm};
  const double steps = step_mm > 0 ? std::floor(request.half_width_mm / step_mm + 1e-9) : 0;
  if (!(steps >= 1) || std::pow(2 * steps + 1, 2) > kMostNodes) {
    throw InputError(
        {.what = "the nodes of the table are too few or too many",
         .where = {.field = "--knot-mm"},
         .got = fmt::format("every {:g} mm over +-{:g} mm", step_mm, request.half_width_mm),
         .expected = "3 to 316 along each axis"});
  }
  table.side = 2 * static_cast<int>(steps) + 1;
  table.first_mm = -steps * step_mm;
  std::array<Sum, 2> before, left, grid;
  const auto both_at = [&](double x_mm, double y_mm) {
    return std::pair{correction_at(correction, machine, request, x_mm, y_mm, 1),
                     correction_at(correction, machine, request, x_mm, y_mm, -1)};
  };
  for (int row = 0; row < table.side; ++row) {
    for (int column = 0; column < table.side; ++column) {
      const auto [up, down] =
          both_at(table.first_mm + step_mm * column, table.first_mm + step_mm * row);
      table.values_mm.emplace_back((up + down) / 2);
      table.directions_mm = std::max(table.directions_mm, (up - down).lpNorm<Eigen::Infinity>());
    }
  }
  for (int row = 0; row + 1 < table.side; ++row) {
    for (int column = 0; column + 1 < table.side; ++column) {
      const double x_mm = table.first_mm + step_mm * (column + 0.5);
      const double y_mm = table.first_mm + step_mm * (row + 0.5);
      const auto [up, down] = both_at(x_mm, y_mm);
      const Eigen::Vector2d carried = table.at(x_mm, y_mm);
      for (int i = 0; i < 2; ++i) {
        const auto axis = static_cast<std::size_t>(i);
        for (const Eigen::Vector2d& one : {up, down}) {
          before[axis].add(one[i]);
          left[axis].add(one[i] - carried[i]);
        }
        grid[axis].add((up[i] + down[i]) / 2 - carried[i]);
      }
    }
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    table.before[axis] = before[axis].error();
    table.left[axis] = left[axis].error();
    table.grid[axis] = grid[axis].error();
  }
  return table;
}

ControllerFile aerotech_file(const PlaneTable& table, const std::string& name) {
  std::string text = aerotech_head("both axes by where both stand");
  text += fmt::format(":START2D 2 1 1 2 {0:.6f} {0:.6f} {1}\n", table.step_mm, table.side);
  text +=
      fmt::format(":START2D POSUNIT=METRIC CORUNIT=METRIC OFFSETROW={0:.6f} OFFSETCOL={0:.6f}\n",
                  table.first_mm);
  for (int row = 0; row < table.side; ++row) {
    for (int column = 0; column < table.side; ++column) {
      const Eigen::Vector2d& v =
          table.values_mm[static_cast<std::size_t>(row * table.side + column)];
      text += fmt::format("{}{:.6f} {:.6f}", column == 0 ? "" : "\t", v[0], v[1]);
    }
    text += "\n";
  }
  return {name, text + ":END\n"};
}

std::vector<std::string> table_words(const PlaneTable& table) {
  std::vector<std::string> words;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    words.push_back(left_in_words(axis == 0 ? "x axis" : "y axis", table.before[axis],
                                  table.left[axis], table.grid[axis], table.step_mm));
  }
  if (const auto sides = sides_in_words("the stage", table.directions_mm)) words.push_back(*sides);
  return words;
}

}  // namespace trammel::job
