#include "core/mechanism/clearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

namespace trammel {

namespace {

/// By brute force: the least distance of points strewn along the parts.
double strewn(const Geometry& g, const Pose& pose, const InverseResult& at) {
  constexpr int kPieces = 200;
  std::array<Eigen::Vector2d, 3> B, C;
  for (std::size_t i = 0; i < 3; ++i) {
    const Chain& c = g.chains[i];
    const double angle = c.beta_rad + pose.phi_rad;
    C[i] = {pose.x_mm + c.r_mm * std::cos(angle), pose.y_mm + c.r_mm * std::sin(angle)};
    const double theta = at.theta_rad[static_cast<Eigen::Index>(i)];
    B[i] = C[i] - c.S_mm * Eigen::Vector2d(std::cos(theta), std::sin(theta));
  }
  double least = 1e9;
  const auto look = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                        const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
    for (int j = 0; j <= kPieces; ++j) {
      for (int k = 0; k <= kPieces; ++k) {
        const Eigen::Vector2d p = a + (b - a) * (static_cast<double>(j) / kPieces);
        const Eigen::Vector2d q = c + (d - c) * (static_cast<double>(k) / kPieces);
        least = std::min(least, (p - q).norm());
      }
    }
  };
  for (std::size_t i = 0; i < 3; ++i) {
    look(B[i], C[i], B[(i + 1) % 3], C[(i + 1) % 3]);
    look(B[i], C[i], C[(i + 1) % 3], C[(i + 2) % 3]);
  }
  return least;
}

}  // namespace

TEST_CASE("the clearance of links is the least distance of points strewn along them",
          "[mechanism]") {
  const Mechanism m = paper_mechanism();
  Random random(5);
  int looked = 0;
  for (int n = 0; n < 400 && looked < 25; ++n) {
    const Pose pose{random.uniform(-250, 250), random.uniform(-250, 250), random.uniform(-2, 2)};
    const InverseResult at = inverse(m.geometry, pose);
    if (!at.ok()) continue;
    ++looked;
    const double exact = link_clearance_mm(m.geometry, at), coarse = strewn(m.geometry, pose, at);
    CHECK(exact <= coarse + 1e-9);
    CHECK(exact >= coarse - 3.2);  // half a piece of a link on either side, and a hair
  }
  CHECK(looked == 25);
}

TEST_CASE("in the middle links are a platform's height apart, far out and turned they can cross",
          "[mechanism]") {
  const Mechanism m = paper_mechanism();
  // From a joint to the opposite side of a triangle inscribed in r: 1.5 r.
  CHECK_THAT(link_clearance_mm(m.geometry, inverse(m.geometry, m.home)), WithinAbs(150, 1e-9));
  Random random(3);
  int crossing = 0;
  for (int n = 0; n < 20'000; ++n) {
    const Pose pose{random.uniform(-300, 300), random.uniform(-300, 300), random.uniform(-3, 3)};
    const InverseResult at = inverse(m.geometry, pose);
    crossing += at.ok() && link_clearance_mm(m.geometry, at) == 0 ? 1 : 0;
  }
  CHECK(crossing > 10);
}

}  // namespace trammel
