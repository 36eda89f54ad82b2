#include "core/calibrate/machine_rank.hpp"

#include <algorithm>

#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// Ranks at constant and varied orientation.
std::vector<int> ranks_of(const Machine& machine, const std::string& parameters = "all") {
  std::vector<int> ranks;
  for (const MachineRank& r : machine_ranks(machine)) {
    if (r.parameters == parameters) ranks.push_back(r.of.rank);
  }
  return ranks;
}

Machine skewed_uvw(double by_deg) {
  Machine machine = starting_machine("3-PPR");
  for (ChainValues& p : machine.chains) p[1] += rad_from_deg(by_deg);
  return machine;
}

}  // namespace

TEST_CASE("each kind of machine has the ranks of an independent program", "[calibrate]") {
  using Ranks = std::vector<int>;
  CHECK(ranks_of(starting_machine("3-PRR")) == Ranks{12, 18});
  CHECK(ranks_of(starting_machine("3-PRR"), "the paper's") == Ranks{12, 15});
  CHECK(ranks_of(starting_machine("3-RPR")) == Ranks{9, 15});
  CHECK(ranks_of(starting_machine("3-PPR")) == Ranks{6, 12});
  for (const double deg : {1., 3., -2.}) CHECK(ranks_of(skewed_uvw(deg)) == Ranks{9, 15});
  CHECK(ranks_of(starting_machine("XY")) == Ranks{4});
  CHECK(ranks_of(starting_machine("X")) == Ranks{1});
}

TEST_CASE("what a machine's readings never tell is said in its own parameters", "[calibrate]") {
  const Identifiability xy = machine_ranks(starting_machine("XY")).front().of;
  std::string all;
  for (const NullDirection& d : xy.null_space) all += d.sentence + "\n";
  CAPTURE(all);
  CHECK(xy.null_space.size() == 4);
  CHECK_THAT(all, Contains("alpha_1 is not identified: no reading depends on it"));
  CHECK_THAT(all, Contains("l_1 and c_1 act as one"));
}
