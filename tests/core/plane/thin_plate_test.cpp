#include "core/plane/thin_plate.hpp"

#include <random>

#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// Places on a lattice of 20 mm, so that none are merged.
std::vector<Place> lattice() {
  std::vector<Place> places;
  for (int x = -100; x <= 100; x += 20) {
    for (int y = -60; y <= 60; y += 20) places.push_back({1.0 * x, 1.0 * y});
  }
  return places;
}

}  // namespace

TEST_CASE("a thin plate meets the values it was laid through", "[assess]") {
  const std::vector<Place> places = lattice();
  std::mt19937_64 random(4);
  Eigen::MatrixXd values(static_cast<Eigen::Index>(places.size()), 2);
  for (double& v : values.reshaped()) v = static_cast<double>(random() % 1000) / 1000;
  const auto surface = thin_plate(places, values);
  REQUIRE(surface);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::VectorXd at = value_at(*surface, places[i]);
    CHECK((at.transpose() - values.row(static_cast<Eigen::Index>(i))).norm() < 1e-9);
  }
}

TEST_CASE("a thin plate through points of a plane is that plane between and beyond them",
          "[assess]") {
  const std::vector<Place> places = lattice();
  const auto plane = [](Place p) { return 0.3 + 0.002 * p.x_mm - 0.005 * p.y_mm; };
  Eigen::MatrixXd values(static_cast<Eigen::Index>(places.size()), 1);
  for (std::size_t i = 0; i < places.size(); ++i) {
    values(static_cast<Eigen::Index>(i), 0) = plane(places[i]);
  }
  const auto surface = thin_plate(places, values);
  REQUIRE(surface);
  for (const Place at : {Place{3, 4}, Place{-77, 51}, Place{150, -90}}) {
    CHECK_THAT(value_at(*surface, at)[0], WithinAbs(plane(at), 1e-9));
  }
}

TEST_CASE("repeats in one place become their mean; a line carries no surface", "[assess]") {
  std::vector<Place> places = lattice();
  places.push_back(places[0]);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(places.size()), 1);
  values(0, 0) = 1;
  const auto surface = thin_plate(places, values);
  REQUIRE(surface);
  CHECK_THAT(value_at(*surface, places[0])[0], WithinAbs(0.5, 1e-9));

  const std::vector<Place> line = {{0, 0}, {10, 10}, {20, 20}, {30, 30}};
  CHECK_FALSE(thin_plate(line, Eigen::MatrixXd::Ones(4, 1)));
  CHECK_FALSE(thin_plate(std::vector<Place>(5, Place{1, 2}), Eigen::MatrixXd::Ones(5, 1)));
}
