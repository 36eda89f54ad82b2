#include "app/job/by_axis.hpp"

#include "tests/support/catch.hpp"

using namespace trammel;
using job::left_by_axis;

namespace {

/// x reads 2 um too much and by turns 3 um either way, y 1 um either way.
Campaign stage_readings() {
  Campaign campaign;
  campaign.machine = starting_machine("XY");
  for (int i = 0; i < 8; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    Reading r;
    r.seq = i + 1;
    r.set = i < 4 ? ReadingSet::identify : ReadingSet::validate;
    r.target = {5.0 * i, -3.0 * i, 0};
    r.conditions.cmd_mm = {5.0 * i, -3.0 * i, 0};
    r.measured = Pose{5.0 * i + 0.002 + 0.003 * sign, -3.0 * i + 0.001 * sign, 0};
    campaign.readings.push_back(r);
  }
  return campaign;
}

}  // namespace

TEST_CASE("what is left is told of each axis, beside what offsets alone leave", "[job]") {
  const Campaign campaign = stage_readings();
  const RobotModel stated = nominal_model(campaign.machine);
  // sqrt((5^2 + 1^2) / 2) = 3.606
  CHECK(left_by_axis(stated, campaign) ==
        "left in x and in y, rms: 3.606 and 1.000 um on 4 fitted readings (offsets alone leave "
        "3.000 and 1.000 um), 3.606 and 1.000 um on 4 held-out readings (offsets alone leave 3.000 "
        "and 1.000 um)");
  Campaign half = campaign;  // the control: a machine that is not measured in both is told nothing
  half.machine.measured = {true, false, false};
  CHECK(left_by_axis(nominal_model(half.machine), half).empty());
  CHECK(left_by_axis(nominal_model(starting_machine("3-PRR")), campaign).empty());
}
