#include "core/mechanism/sensitivity.hpp"

#include "core/error.hpp"
#include "core/plan/grids.hpp"
#include "tests/support/catch.hpp"

namespace trammel {

namespace {

constexpr int kX = 0, kY = 1, kPhi = 2;

/// Share of the angle sources (alpha and beta) of each chain among all angle sources: Table II.
Eigen::Matrix3d angle_shares_by_chain(const Eigen::MatrixXd& shares) {
  Eigen::Matrix3d by_chain;
  for (int i = 0; i < 3; ++i) {
    for (int chain = 0; chain < kChains; ++chain) {
      by_chain(i, chain) = shares(i, 6 * chain) + shares(i, 6 * chain + 1);
    }
    by_chain.row(i) /= by_chain.row(i).sum();
  }
  return by_chain;
}

Eigen::MatrixXd paper_shares() {
  return sensitivity(machine_of(paper_mechanism()), lattice(100, 10)).of;
}

}  // namespace

TEST_CASE("sensitivity shares are positive and sum to 1 in x, y and phi", "[mechanism]") {
  const Eigen::MatrixXd shares = paper_shares();
  CHECK(shares.cols() == kPaperParameters);
  CHECK(shares.minCoeff() >= 0);
  for (int i = 0; i < 3; ++i) CHECK_THAT(shares.row(i).sum(), WithinAbs(1, 1e-12));
  for (const char* kind : {"3-PPR", "3-RPR", "XY", "X"}) {
    const Machine machine = starting_machine(kind);
    const Eigen::MatrixXd of = sensitivity(machine, std::vector<Pose>{machine.home}).of;
    CHECK(of.rows() == machine.kind->n_chains);
    for (Eigen::Index i = 0; i < of.rows(); ++i) CHECK_THAT(of.row(i).sum(), WithinAbs(1, 1e-12));
  }
}

TEST_CASE("Table II: chains 2 and 3 lead in x, chain 1 is most prominent in y", "[mechanism]") {
  const Eigen::Matrix3d by_chain = angle_shares_by_chain(paper_shares());
  INFO(by_chain);
  CHECK(by_chain(kX, 1) > 1.5 * by_chain(kX, 0));
  CHECK(by_chain(kX, 2) > 1.5 * by_chain(kX, 0));
  CHECK(by_chain(kY, 0) > by_chain(kY, 1));
  CHECK(by_chain(kY, 0) > by_chain(kY, 2));
  CHECK(by_chain.row(kY).minCoeff() > 0.1);    // all three count
  CHECK(by_chain.row(kPhi).minCoeff() > 0.3);  // by symmetry a third each
  CHECK(by_chain.row(kPhi).maxCoeff() < 0.37);
}

TEST_CASE("joint zero and rail distance have the same sensitivity", "[mechanism]") {
  const Eigen::MatrixXd shares = paper_shares();
  for (int chain = 0; chain < kChains; ++chain) {
    for (int i = 0; i < 3; ++i) {
      CHECK_THAT(shares(i, 6 * chain + 4), WithinRel(shares(i, 6 * chain + 5), 1e-12));
    }
  }
}

TEST_CASE("sensitivity at one pose is the quotient of Eq. 20", "[mechanism]") {
  const Machine machine = machine_of(paper_mechanism());
  const std::vector<Pose> poses = {{30, -40, 0.05}};
  // Twice the angle error: each angle's share against each length's doubles.
  const Eigen::MatrixXd one = sensitivity(machine, poses).of;
  SourceErrors doubled;
  doubled.angle_rad *= 2;
  const Eigen::MatrixXd two = sensitivity(machine, poses, doubled).of;
  for (int i = 0; i < 3; ++i) {
    const double before = one(i, 0) / one(i, 3), after = two(i, 0) / two(i, 3);
    CHECK_THAT(after, WithinRel(2 * before, 1e-12));
  }
}

TEST_CASE("sensitivity refuses no poses and names one out of reach", "[mechanism]") {
  const Machine machine = machine_of(paper_mechanism());
  CHECK_THROWS_AS(sensitivity(machine, {}), InputError);
  CHECK_THROWS_WITH(sensitivity(machine, std::vector<Pose>{{}, {900, 0, 0}}),
                    Contains("out of reach of chain 1") && Contains("x 900"));
  CHECK_THROWS_WITH(sensitivity(machine, std::vector<Pose>{{0, 0, rad_from_deg(60)}}),
                    Contains("a pose is singular"));
}

}  // namespace trammel
