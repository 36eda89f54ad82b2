#include "core/mechanism/clearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace trammel {

namespace {

using Point = Eigen::Vector2d;
struct Segment {
  Point a, b;
};

double distance(const Point& p, const Segment& s) {
  const Point along = s.b - s.a;
  const double t = std::clamp((p - s.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - s.a - t * along).norm();
}

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

/// 0 where they cross, else from an end of one to the other.
double distance(const Segment& s, const Segment& t) {
  const Point u = s.b - s.a, v = t.b - t.a;
  const double side_1 = cross(u, t.a - s.a) * cross(u, t.b - s.a);
  const double side_2 = cross(v, s.a - t.a) * cross(v, s.b - t.a);
  if (side_1 < 0 && side_2 < 0) return 0;
  return std::min({distance(s.a, t), distance(s.b, t), distance(t.a, s), distance(t.b, s)});
}

}  // namespace

double link_clearance_mm(const Geometry& geometry, const InverseResult& at) {
  std::array<Link, kChains> links;
  for (std::size_t i = 0; i < kChains; ++i) {
    const Chain& chain = geometry.chains[i];
    const Point u(std::cos(chain.alpha_rad), std::sin(chain.alpha_rad));
    const Point n(-u.y(), u.x());
    const double theta = at.theta_rad[static_cast<Eigen::Index>(i)];
    const double l = at.l_mm[static_cast<Eigen::Index>(i)] + chain.l_zero_mm - chain.R_mm;
    links[i].base = l * u + chain.h_mm * n;
    links[i].platform = links[i].base + chain.S_mm * Point(std::cos(theta), std::sin(theta));
  }
  return link_clearance_mm(links);
}

double link_clearance_mm(const std::array<Link, kChains>& links) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kChains; ++i) {
    const Link &link = links[i], &next = links[(i + 1) % kChains], &last = links[(i + 2) % kChains];
    const Segment here = {link.base, link.platform};
    least = std::min({least, distance(here, {next.base, next.platform}),
                      distance(here, {next.platform, last.platform})});
  }
  return least;
}

}  // namespace trammel
