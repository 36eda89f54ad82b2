#include "core/diagnose/structure.hpp"

#include "core/statistics/random.hpp"
#include "tests/core/diagnose/space.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

ResidualSpace clean_space(std::uint64_t seed) {
  return space_of(make_case({.thinning = 0.4}, {}, 0, seed).campaign);
}

}  // namespace

TEST_CASE("the tail of chi^2 is the one in tables", "[diagnose]") {
  CHECK_THAT(chi2_tail(3.841458820694124, 1), WithinRel(0.05, 1e-9));
  CHECK_THAT(chi2_tail(11.344866730144373, 3), WithinRel(0.01, 1e-9));
  CHECK_THAT(chi2_tail(40.0, 2), WithinRel(std::exp(-20.0), 1e-9));
}

TEST_CASE("the family-wise p of white noise is uniform", "[diagnose]") {
  ResidualSpace space = clean_space(1);
  const auto shapes = dictionary(space);
  Random random(5);
  int below = 0;
  const int trials = 100;
  for (int t = 0; t < trials; ++t) {
    Eigen::VectorXd noise(space.rows());
    for (double& v : noise) v = random.normal();
    space.residual = space.project(noise);
    // level 1: every trial is bootstrapped in full
    below += test_structure(space, shapes, {.replicates = 300, .level = 1, .seed = 3, .threads = 2})
                 .family_p < 0.2;
  }
  // binomial(100, 0.2): outside 20 +- 13 in 0.1 % of draws
  CHECK(std::abs(below - 20) <= 13);
}

TEST_CASE("a shape put into white noise is found by its own name", "[diagnose]") {
  ResidualSpace space = clean_space(2);
  const auto shapes = dictionary(space);
  for (const std::size_t hidden : {std::size_t{5}, std::size_t{60}, shapes.size() - 20}) {
    const Eigen::VectorXd clean = space.residual;
    const Eigen::VectorXd signal = space.project(shapes[hidden].columns.col(0));
    space.residual = clean + 15 / signal.norm() * signal;
    const StructureTest test = test_structure(space, shapes);
    INFO(shapes[hidden].where << "; " << shapes[hidden].when);
    CHECK(test.family_p < 1e-4);
    const double best = test.findings.front().p;
    for (const Finding& f : test.findings) {
      if (f.where == shapes[hidden].where && f.when == shapes[hidden].when)
        CHECK(f.p < std::sqrt(best));
    }
    space.residual = clean;
  }
}
