#include "app/report/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "app/files/numbers.hpp"
#include "app/report/print.hpp"
#include "app/terminal/columns.hpp"
#include "app/terminal/lines.hpp"

namespace trammel::report {

namespace {

constexpr int kEighths = 8;
constexpr int kMostCells = 17;  // across one map: two maps of them fit 100 columns
constexpr int kMostBarColumns = 60;
constexpr int kBesideBar = 22;      // the method before it, its figure behind it
constexpr double kRounding = 1e-9;  // a share of just so many eighths is not one more
constexpr double kSame_mm = 1e-6;   // coordinates that differ by less are one

using Levels = std::array<const char*, kEighths>;
constexpr Levels kHeights = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr Levels kLetters = {".", ":", "-", "=", "+", "*", "#", "@"};
constexpr Levels kWidths = {"▏", "▎", "▍", "▌", "▋", "▊", "▉", "█"};

const Levels& levels(Glyphs glyphs) { return glyphs == Glyphs::blocks ? kHeights : kLetters; }

/// Cells of one axis: their pitch is the points' own, or wider where that would be too many.
struct Axis {
  double low_mm = 0;
  double high_mm = 0;
  double nearest_mm = 0;  // least distance of two different coordinates
};

Axis axis_of(std::vector<double> values_mm) {
  std::ranges::sort(values_mm);
  Axis axis{values_mm.front(), values_mm.back(), values_mm.back() - values_mm.front()};
  for (std::size_t k = 1; k < values_mm.size(); ++k) {
    const double step_mm = values_mm[k] - values_mm[k - 1];
    if (step_mm > kSame_mm) axis.nearest_mm = std::min(axis.nearest_mm, step_mm);
  }
  return axis;
}

struct Cell {
  double before = 0, after = 0;
  int n = 0;
};

struct Grid {
  Axis x, y;
  double pitch_mm = 0;
  int columns = 0, rows = 0;
  std::map<std::pair<int, int>, Cell> cells;  // row from below, column; sums divided by n
  double largest = 0;
};

Grid grid_of(const std::vector<PointError>& points) {
  std::vector<double> xs, ys;
  for (const PointError& p : points) {
    xs.push_back(p.x_mm);
    ys.push_back(p.y_mm);
  }
  Grid grid{.x = axis_of(xs), .y = axis_of(ys), .cells = {}};
  const double extent_mm = std::max(grid.x.high_mm - grid.x.low_mm, grid.y.high_mm - grid.y.low_mm);
  if (extent_mm <= kSame_mm) return grid;
  const double nearest_mm = std::max(grid.x.nearest_mm, grid.y.nearest_mm);
  grid.pitch_mm = std::max(nearest_mm, extent_mm / (kMostCells - 1));
  const auto cell = [&grid](double value_mm, const Axis& axis) {
    return static_cast<int>(std::lround((value_mm - axis.low_mm) / grid.pitch_mm));
  };
  grid.columns = cell(grid.x.high_mm, grid.x) + 1;
  grid.rows = cell(grid.y.high_mm, grid.y) + 1;
  for (const PointError& p : points) {
    Cell& at = grid.cells[{cell(p.y_mm, grid.y), cell(p.x_mm, grid.x)}];
    at.before += p.before;
    at.after += p.after;
    ++at.n;
  }
  for (auto& [place, c] : grid.cells) {
    c.before /= c.n;
    c.after /= c.n;
    grid.largest = std::max({grid.largest, c.before, c.after});
  }
  return grid;
}

std::string half_row(const Grid& grid, int row, double Cell::*side, Glyphs glyphs) {
  std::string text;
  for (int column = 0; column < grid.columns; ++column) {
    const auto at = grid.cells.find({row, column});
    if (at == grid.cells.end()) {
      text += "  ";
      continue;
    }
    const double share = grid.largest > 0 ? at->second.*side / grid.largest : 0;
    const int eighth =
        std::clamp(static_cast<int>(std::ceil(kEighths * share - kRounding)), 1, kEighths);
    text += std::string(levels(glyphs)[static_cast<std::size_t>(eighth - 1)]) + " ";
  }
  return text;
}

/// "-60" at the left end and "60" at the right end of `width` columns.
std::string ends(const std::string& left, const std::string& right, int width) {
  const int blanks = width - static_cast<int>(left.size() + right.size());
  return left + std::string(static_cast<std::size_t>(std::max(blanks, 1)), ' ') + right;
}

std::string coordinate(double value_mm) { return fmt::format("{:g}", rounded(value_mm, 1)); }

std::string trimmed(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string judged_words(const ErrorTable& table) {
  return fmt::format("{}, {}", name_of(table.standing), points_in_words(table.before.n));
}

/// What a bar measures.
struct Scale {
  double full = 0;
  int columns = 0;  // of the full value
  std::optional<double> floor = {};
};

std::string bar(double value, const Scale& scale, Glyphs glyphs) {
  const double eighths = std::round(kEighths * scale.columns * value / scale.full);
  const int full = static_cast<int>(eighths) / kEighths,
            rest = static_cast<int>(eighths) % kEighths;
  const bool blocks = glyphs == Glyphs::blocks;
  const int mark =
      scale.floor ? static_cast<int>(std::floor(scale.columns * *scale.floor / scale.full)) : -1;
  std::string text;
  for (int column = 0; column < scale.columns; ++column) {
    if (column == mark) {
      text += blocks ? "│" : "|";
    } else if (column < full) {
      text += blocks ? "█" : "#";
    } else if (column == full && rest > 0) {
      text += blocks                 ? kWidths[static_cast<std::size_t>(rest - 1)]
              : rest >= kEighths / 2 ? "#"
                                     : " ";
    } else {
      text += " ";
    }
  }
  return text;
}

}  // namespace

std::string error_map(const ErrorTable& table, Glyphs glyphs, int columns) {
  if (table.points.empty()) return "";
  const Grid grid = grid_of(table.points);
  if (grid.columns == 0) return "";
  const int width = 2 * grid.columns;
  const std::string left = coordinate(grid.x.low_mm), right = coordinate(grid.x.high_mm);
  const int half = std::max({width, 6, static_cast<int>(left.size() + right.size()) + 1});
  const int needed = 2 * half + 12;
  if (needed > columns) {
    return fmt::format("the map needs {} columns, here are {}\n", needed, columns);
  }
  std::string text = trimmed(fmt::format("{:>6}  {:<{}}    {}", "y mm", "before", half,
                                         table.after_predicted ? "after *" : "after"));
  for (int row = grid.rows - 1; row >= 0; --row) {
    const bool labelled = row == grid.rows - 1 || row == 0;
    const std::string label =
        labelled ? coordinate(row == 0 ? grid.y.low_mm : grid.y.high_mm) : std::string();
    text +=
        trimmed(fmt::format("{:>6}  {}{}    {}", label, half_row(grid, row, &Cell::before, glyphs),
                            std::string(static_cast<std::size_t>(half - width), ' '),
                            half_row(grid, row, &Cell::after, glyphs)));
  }
  const std::string under = ends(left, right, width - 1);
  text += trimmed(fmt::format("{:>6}  {:<{}}    {}", "x mm", under, half, under));
  const auto& marks = levels(glyphs);
  return text +
         fmt::format(
             "{0} to {3:.{6}f}, {1} to {4:.{6}f}, {2} to {5:.{6}f} {7}; a cell is {8:g} mm\n",
             marks[0], marks[3], marks[7], grid.largest / kEighths, grid.largest / 2, grid.largest,
             table.decimals, table.unit, rounded(grid.pitch_mm, 1));
}

std::string method_bars(const Report& report, const ErrorTable& table, Glyphs glyphs, int columns) {
  if (table.before.mean <= 0) return "";
  const Scale scale{.full = table.before.mean,
                    .columns = std::clamp(columns - kBesideBar, 0, kMostBarColumns),
                    .floor = report.floor_mean_mm};
  const auto line = [&](const std::string& name, double value) {
    return trimmed(
        fmt::format("{:<12} {} {:.{}f}", name, bar(value, scale, glyphs), value, table.decimals));
  };
  std::string text = fmt::format("mean, {} [{}]\n", judged_words(table), table.unit);
  text += line("before", table.before.mean);
  for (const ErrorTable& other : report.tables) {
    if (other.figure != table.figure || other.standing != table.standing ||
        other.before.n != table.before.n || other.before.mean != table.before.mean) {
      continue;
    }
    text += line(other.method + (other.after_predicted ? " *" : ""), other.after.mean);
  }
  if (!report.floor_mean_mm) return text;
  return text + fmt::format("{} mean length of a perfect reading, {:.{}f}\n",
                            glyphs == Glyphs::blocks ? "│" : "|", *report.floor_mean_mm,
                            table.decimals);
}

std::string pictures(const Report& report, Glyphs glyphs) {
  const auto columns = static_cast<int>(terminal::terminal_columns().value_or(kWide));
  const ErrorTable* table = best_table(report);
  if (table == nullptr) return "";
  const std::string map = error_map(*table, glyphs, columns);
  return terminal::heading(fmt::format("Where the error is [{}]: {}, {}", table->unit,
                                       table->method, judged_words(*table))) +
         map + (map.empty() ? "" : "\n") + method_bars(report, *table, glyphs, columns);
}

}  // namespace trammel::report
