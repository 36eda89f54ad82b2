// core/ as a library: numbers in, numbers out. A robot whose second screw has a lead 0.3 % too long
// is measured on the paper's 80 points, calibrated by least squares, and asked for a pose it never
// saw.
//
//   residual = measured - predicted; identified parameters d minimise sum |W (delta X - J_e d)|^2
//   (21)

#include <cstdio>

#include "core/calibrate/correction.hpp"
#include "core/calibrate/lsq.hpp"
#include "core/judge/deviation.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/plan/grids.hpp"
#include "core/simulate/virtual_robot.hpp"
#include "core/units.hpp"

using namespace trammel;

int main() {
  const Mechanism stated = paper_mechanism();
  simulate::Truth truth;
  truth.nominal = machine_of(stated);
  truth.actual = truth.nominal.chains;
  truth.drive.lead_scale = {0, 0.003, 0};
  const simulate::VirtualRobot robot(truth);

  std::vector<Reading> readings;
  for (const Pose& target : paper_80()) {
    Reading r;
    r.seq = static_cast<int>(readings.size()) + 1;
    r.target = target;
    r.conditions.cmd_mm = inverse(stated.geometry, target).l_mm;
    r.measured = robot.read(r.conditions, static_cast<std::uint64_t>(r.seq)).pose;
    readings.push_back(r);
  }
  const LsqResult found =
      identify_linear(stated, readings, {.xy_mm = 0.010, .phi_rad = rad_from_deg(0.004)});

  const Pose unseen{45, -35, 0};
  for (const Correction& correction :
       {Correction{}, Correction{GeometryCorrection{found.geometry}}}) {
    const Conditions there{.cmd_mm = commanded(correction, stated, {.target = unseen}).l_mm};
    std::printf("%-8s position error at an unseen pose: %.4f mm\n", kind_of(correction).c_str(),
                position_error_mm(robot.true_pose(there).pose, unseen));
  }
}
