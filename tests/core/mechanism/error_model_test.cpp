#include "core/mechanism/error_model.hpp"

#include "core/mechanism/error_rows.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/inverse.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

namespace {

ErrorJacobian at_pose(const Geometry& geometry, const Pose& pose) {
  const RailFrames frames = rail_frames(geometry);
  return error_jacobian(frames, chains_at(frames, pose.vector()));
}

}  // namespace

TEST_CASE("the error Jacobian gives the golden rows", "[mechanism]") {
  const auto table = tests::read_table("core/mechanism/golden/error_jacobian_nominal.csv");
  const Geometry geometry = paper_mechanism().geometry;
  REQUIRE(table.rows.size() >= 20);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const Pose pose{table.number(row, "x_mm"), table.number(row, "y_mm"),
                    table.number(row, "phi_rad")};
    const auto J = at_pose(geometry, pose);
    const std::string& name = table.text(row, "row");
    const int r = name == "x" ? 0 : name == "y" ? 1 : 2;
    for (int k = 0; k < kPaperParameters; ++k) {
      const double golden = table.number(row, table.columns[static_cast<std::size_t>(k) + 4]);
      CHECK_THAT(J(r, k), WithinRel(golden, 1e-9) || WithinAbs(golden, 1e-13));
    }
  }
}

TEST_CASE("the error Jacobian is the derivative of the forward kinematics by all 21 parameters",
          "[mechanism]") {
  Random random(7);
  for (int trial = 0; trial < 50; ++trial) {
    const Geometry g = tests::random_geometry(random, 3);
    const Pose pose = tests::random_pose(random);
    const auto at = inverse(g, pose);
    const auto J = at_pose(g, pose);
    for (int k = 0; k < kGeometryParameters; ++k) {
      const bool angle = geometry_parameters()[static_cast<std::size_t>(k)].is_angle;
      const double step = angle ? 1e-7 : 1e-4;
      const GeometryVector d = GeometryVector::Unit(k) * step;
      const auto plus = forward(from_vector(to_vector(g) + d), at.l_mm, pose);
      const auto minus = forward(from_vector(to_vector(g) - d), at.l_mm, pose);
      const Eigen::Vector3d slope = (plus.pose.vector() - minus.pose.vector()) / (2 * step);
      CHECK((slope - J.col(k)).cwiseAbs().maxCoeff() < 1e-6 * (1 + J.col(k).cwiseAbs().maxCoeff()));
    }
  }
}

TEST_CASE("joint zero and rail radius are one parameter: their columns are opposites",
          "[mechanism]") {
  const Geometry g = paper_mechanism().geometry;
  const Pose pose{30, -40, 0.05};
  const auto J = at_pose(g, pose);
  for (int i = 0; i < 3; ++i) CHECK(J.col(6 * i + 4) == -J.col(6 * i + 5));
}

TEST_CASE("rows of many poses are those of single calls, wherever a pose stands and on every level",
          "[mechanism]") {
  Random random(12);
  const Geometry geometry = tests::random_geometry(random, 3);
  const RailFrames frames = rail_frames(geometry);
  std::vector<Pose> truth, starts;
  std::vector<Displacements> l;
  for (int k = 0; k < 83; ++k) {
    truth.push_back(tests::random_pose(random));
    l.push_back(inverse(geometry, truth.back()).l_mm);
    starts.push_back({truth.back().x_mm + random.uniform(-5, 5),
                      truth.back().y_mm + random.uniform(-5, 5),
                      truth.back().phi_rad + random.uniform(-0.05, 0.05)});
  }
  l[7] = Displacements::Constant(5000);  // out of reach
  starts[20] = {0, 5000, 0};             // from where no step leads
  std::vector<Pose> poses = starts;
  Eigen::MatrixXd J;
  CHECK(error_rows(frames, l, poses, J) == std::vector<std::size_t>{7, 20});
  for (std::size_t k = 0; k < l.size(); ++k) {
    if (k == 7 || k == 20) continue;
    CHECK((poses[k].vector() - truth[k].vector()).cwiseAbs().maxCoeff() < 1e-9);
    const ErrorJacobian single = error_jacobian(frames, chains_at(frames, truth[k].vector()));
    CHECK((J.middleRows<3>(static_cast<Eigen::Index>(3 * k)) - single).cwiseAbs().maxCoeff() <
          1e-9 * (1 + single.cwiseAbs().maxCoeff()));
    std::vector<Pose> alone = {starts[k]};
    Eigen::MatrixXd rows;
    REQUIRE(error_rows(frames, std::span(&l[k], 1), alone, rows).empty());
    CHECK(alone[0] == poses[k]);
    CHECK(rows == J.middleRows<3>(static_cast<Eigen::Index>(3 * k)));
  }
  for (const CpuLevel level : tests::levels_here()) {
    std::vector<Pose> again = starts;
    Eigen::MatrixXd rows;
    CHECK(error_rows(frames, l, again, rows, level).size() == 2);
    for (std::size_t k = 0; k < l.size(); ++k) {
      if (k == 7 || k == 20) continue;
      CHECK(again[k] == poses[k]);
      const auto three = Eigen::seqN(static_cast<Eigen::Index>(3 * k), 3);
      CHECK(rows(three, Eigen::all) == J(three, Eigen::all));
    }
  }
}
