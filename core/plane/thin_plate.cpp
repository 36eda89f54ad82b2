#include "core/plane/thin_plate.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"
#include "core/plane/hull.hpp"

namespace trammel {

namespace {

constexpr int kCells = 24;          // at most 625 places: a system that is solved in some 10 ms
constexpr double kThinnest = 1e-6;  // area of the hull over the square of its extent

double kernel(double d2) { return d2 > 0 ? 0.5 * d2 * std::log(d2) : 0; }

double extent_mm(std::span<const Place> places) {
  const auto range = [places](double Place::*axis) {
    const auto [low, high] =
        std::minmax_element(places.begin(), places.end(),
                            [axis](const Place& a, const Place& b) { return a.*axis < b.*axis; });
    return *high.*axis - *low.*axis;
  };
  return std::max(range(&Place::x_mm), range(&Place::y_mm));
}

double area(const std::vector<Place>& hull) {
  double twice = 0;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Place a = hull[k], b = hull[(k + 1) % hull.size()];
    twice += a.x_mm * b.y_mm - b.x_mm * a.y_mm;
  }
  return twice / 2;
}

/// Means over the cells of a grid: of the places, and of their values.
struct Merged {
  std::vector<Place> places;
  Eigen::MatrixXd values;
};
Merged merge(std::span<const Place> places, const Eigen::MatrixXd& values, double cell_mm) {
  std::map<std::pair<long, long>, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < places.size(); ++i) {
    cells[{std::lround(places[i].x_mm / cell_mm), std::lround(places[i].y_mm / cell_mm)}].push_back(
        i);
  }
  Merged merged{
      .places = {},
      .values = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(cells.size()), values.cols())};
  for (const auto& [cell, members] : cells) {
    const double n = static_cast<double>(members.size());
    const auto row = static_cast<Eigen::Index>(merged.places.size());
    Place mean;
    for (const std::size_t i : members) {
      mean.x_mm += places[i].x_mm / n;
      mean.y_mm += places[i].y_mm / n;
      merged.values.row(row) += values.row(static_cast<Eigen::Index>(i)) / n;
    }
    merged.places.push_back(mean);
  }
  return merged;
}

}  // namespace

std::optional<ThinPlate> thin_plate(std::span<const Place> places, const Eigen::MatrixXd& values) {
  if (places.size() < 3) return std::nullopt;
  const double extent = extent_mm(places);
  if (!(extent > 0)) return std::nullopt;
  const Merged merged = merge(places, values, extent / kCells);
  if (merged.places.size() < 3 || area(convex_hull(merged.places)) < kThinnest * extent * extent) {
    return std::nullopt;
  }
  ThinPlate surface{.places = merged.places, .weights = {}, .scale_mm = extent};
  for (Place& p : surface.places) p = {p.x_mm / extent, p.y_mm / extent};
  const auto n = static_cast<Eigen::Index>(surface.places.size());
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + 3, n + 3);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n + 3, values.cols());
  right.topRows(n) = merged.values;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Place a = surface.places[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < i; ++j) {
      const Place b = surface.places[static_cast<std::size_t>(j)];
      const double dx = a.x_mm - b.x_mm, dy = a.y_mm - b.y_mm;
      system(i, j) = system(j, i) = kernel(dx * dx + dy * dy);
    }
    system.block<1, 3>(i, n) << 1, a.x_mm, a.y_mm;
    system.block<3, 1>(n, i) = system.block<1, 3>(i, n).transpose();
  }
  surface.weights = solve_square(system, right);
  return surface;
}

Eigen::VectorXd value_at(const ThinPlate& surface, Place at) {
  const double x = at.x_mm / surface.scale_mm, y = at.y_mm / surface.scale_mm;
  const auto n = static_cast<Eigen::Index>(surface.places.size());
  Eigen::VectorXd basis(n + 3);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Place p = surface.places[static_cast<std::size_t>(j)];
    basis[j] = kernel((x - p.x_mm) * (x - p.x_mm) + (y - p.y_mm) * (y - p.y_mm));
  }
  basis.tail<3>() << 1, x, y;
  return transposed_times(surface.weights, basis);
}

}  // namespace trammel
