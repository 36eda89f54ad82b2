#pragma once
// Where to measure: sets of target poses, at phi = 0 unless stated otherwise.

#include <cstdint>
#include <span>
#include <vector>

#include "core/mechanism/geometry.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

/// The paper's 80 points: 4 * count on the axes at every step, then 4 * count on the diagonals
/// (+-k step, +-k step). Source: Zhang et al. 2024, Sec. 3.3; which points lie in the quadrants is
/// not printed: on the diagonals the table's max/mean and min/mean come out as printed.
std::vector<Pose> paper_80(double step_mm = 10, int count = 10);

/// 48 points that the 80 do not contain: {20, 40, 60, 80}^2 (1 to 4 steps) less its diagonal, in
/// four quadrants.
std::vector<Pose> paper_48(double step_mm = 20);

/// `count` points of a lattice of +-half_width_mm, each the farthest from all `samples` and from
/// those chosen before (ties: the first in order of y, x). Source: Sec. 4.2 "starting with the
/// farthest".
std::vector<Pose> farthest_points(std::span<const Pose> samples, int count,
                                  double half_width_mm = 100, double step_mm = 10);

/// All points of a square lattice through (0, 0), row by row.
std::vector<Pose> lattice(double half_width_mm, double step_mm);

/// `count` points on a circle, from the +x side, counterclockwise.
struct Circle {
  double x_mm = 0;
  double y_mm = 0;
  double radius_mm = 50;
};
std::vector<Pose> circle(const Circle& circle, int count = 72);

/// The paper's four circles: radius 50 mm about (50, 0), (0, 50), (-50, 0), (0, -50) (Sec. 4.4).
const std::vector<Circle>& paper_circles();

/// Order of a list of poses. Nearest: each time the closest of those left, from `start`.
enum class Order { as_listed, random, nearest };
std::vector<Pose> ordered(std::span<const Pose> poses, Order order, std::uint64_t seed = 1,
                          const Pose& start = {});

}  // namespace trammel
