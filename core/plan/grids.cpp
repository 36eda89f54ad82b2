#include "core/plan/grids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr int kMaxPoints = 1000000;  // a year of measuring

void require(bool ok, const std::string& what, const std::string& got) {
  if (!ok) throw InputError({.what = what, .got = got});
}

double distance2(const Pose& a, const Pose& b) {
  const double dx = a.x_mm - b.x_mm, dy = a.y_mm - b.y_mm;
  return dx * dx + dy * dy;
}

/// One radian counts as the paper's platform radius.
double travel2(const Pose& a, const Pose& b) {
  constexpr double kLeverMm = 100;
  const double turn = kLeverMm * (a.phi_rad - b.phi_rad);
  return distance2(a, b) + turn * turn;
}

std::vector<Pose> nearest_first(std::vector<Pose> left, Pose at) {
  std::vector<Pose> out;
  out.reserve(left.size());
  while (!left.empty()) {
    const auto next = std::min_element(left.begin(), left.end(), [&](const Pose& a, const Pose& b) {
      return travel2(a, at) < travel2(b, at);
    });
    at = *next;
    out.push_back(at);
    left.erase(next);
  }
  return out;
}

}  // namespace

std::vector<Pose> paper_80(double step_mm, int count) {
  require(std::isfinite(step_mm) && step_mm > 0, "a grid needs a positive step",
          std::to_string(step_mm) + " mm");
  require(count >= 1 && count <= kMaxPoints / 8, "a grid needs 1 to 125000 points per arm",
          std::to_string(count));
  constexpr std::array<std::pair<int, int>, 8> kArms = {
      {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  std::vector<Pose> poses;
  for (const auto& [x, y] : kArms) {
    for (int k = 1; k <= count; ++k) poses.push_back({x * k * step_mm, y * k * step_mm, 0});
  }
  return poses;
}

std::vector<Pose> paper_48(double step_mm) {
  require(std::isfinite(step_mm) && step_mm > 0, "a grid needs a positive step",
          std::to_string(step_mm) + " mm");
  constexpr std::array<std::pair<int, int>, 4> kQuadrants = {{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  std::vector<Pose> poses;
  for (const auto& [sx, sy] : kQuadrants) {
    for (int x = 1; x <= 4; ++x) {
      for (int y = 1; y <= 4; ++y) {
        if (x != y) poses.push_back({sx * x * step_mm, sy * y * step_mm, 0});
      }
    }
  }
  return poses;
}

std::vector<Pose> lattice(double half_width_mm, double step_mm) {
  const double n = std::floor(half_width_mm / step_mm + 1e-9);
  require(step_mm > 0 && n >= 0 && (2 * n + 1) * (2 * n + 1) <= kMaxPoints,
          "a lattice needs a positive step and at most a million points",
          "half width " + std::to_string(half_width_mm) + " mm, step " + std::to_string(step_mm) +
              " mm");
  const int count = static_cast<int>(n);
  std::vector<Pose> poses;
  for (int row = -count; row <= count; ++row) {
    for (int column = -count; column <= count; ++column) {
      poses.push_back({column * step_mm, row * step_mm, 0});
    }
  }
  return poses;
}

std::vector<Pose> farthest_points(std::span<const Pose> samples, int count, double half_width_mm,
                                  double step_mm) {
  const std::vector<Pose> candidates = lattice(half_width_mm, step_mm);
  std::vector<double> nearest(candidates.size(), std::numeric_limits<double>::infinity());
  const auto take = [&](const Pose& taken) {
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      nearest[k] = std::min(nearest[k], distance2(candidates[k], taken));
    }
  };
  for (const Pose& sample : samples) take(sample);
  std::vector<Pose> chosen;
  while (static_cast<int>(chosen.size()) < count) {
    const auto far = std::max_element(nearest.begin(), nearest.end());
    require(*far > 0, "the lattice has too few free points",
            std::to_string(chosen.size()) + " of " + std::to_string(count));
    chosen.push_back(candidates[static_cast<std::size_t>(far - nearest.begin())]);
    take(chosen.back());
  }
  return chosen;
}

std::vector<Pose> circle(const Circle& circle, int count) {
  require(std::isfinite(circle.radius_mm) && circle.radius_mm > 0,
          "a circle needs a positive radius", std::to_string(circle.radius_mm) + " mm");
  require(count >= 3 && count <= kMaxPoints, "a circle needs 3 to a million points",
          std::to_string(count));
  std::vector<Pose> poses;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * kPi * k / count;
    poses.push_back({circle.x_mm + circle.radius_mm * std::cos(angle),
                     circle.y_mm + circle.radius_mm * std::sin(angle), 0});
  }
  return poses;
}

const std::vector<Circle>& paper_circles() {
  static const std::vector<Circle> circles = {{50, 0, 50}, {0, 50, 50}, {-50, 0, 50}, {0, -50, 50}};
  return circles;
}

std::vector<Pose> ordered(std::span<const Pose> poses, Order order, std::uint64_t seed,
                          const Pose& start) {
  std::vector<Pose> out(poses.begin(), poses.end());
  if (order == Order::nearest) return nearest_first(std::move(out), start);
  if (order == Order::random) {
    Random random = Random::stream(seed, "order of points");
    for (std::size_t n = out.size(); n > 1; --n) std::swap(out[n - 1], out[random.below(n)]);
  }
  return out;
}

}  // namespace trammel
