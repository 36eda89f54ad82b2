#include "core/calibrate/simulation.hpp"

#include "core/error.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

TEST_CASE("simulated on the robot itself, the errors are those that were measured, to the noise",
          "[calibrate]") {
  Random random(51);
  const Geometry truth = random_geometry(random, 3);
  const auto readings = measure(truth, paper_80(), random, {1e-9, 1e-12});
  const auto same = simulated_errors(GeometryCorrection{truth}, paper_mechanism(), readings);
  REQUIRE(same.size() == 80);
  for (const SimulatedError& e : same) {
    CHECK((e.measured - e.simulated).cwiseAbs().maxCoeff() < 1e-8);
  }
  const SimulationScore score = simulation_score(same);
  CHECK(score.left.max < 1e-8);
  CHECK_THAT(score.simulated.mean, WithinRel(score.measured.mean, 1e-6));
  CHECK(score.measured.mean > 0.01);

  const auto nominal = simulated_errors(NominalCorrection{}, paper_mechanism(), readings);
  const SimulationScore none = simulation_score(nominal);
  CHECK(none.simulated.max == 0);
  CHECK_THAT(none.left.mean, WithinRel(none.measured.mean, 1e-12));
}

TEST_CASE("rows without a pose are not simulated, and a command out of reach is named",
          "[calibrate]") {
  Random random(52);
  auto readings = measure(paper_mechanism().geometry, paper_80(), random);
  readings[3].measured.reset();
  CHECK(simulated_errors(NominalCorrection{}, paper_mechanism(), readings).size() == 79);
  readings[5].conditions.cmd_mm = {1, 600, 0};
  CHECK_THROWS_WITH(simulated_errors(NominalCorrection{}, paper_mechanism(), readings),
                    Contains("seq 6"));
}
