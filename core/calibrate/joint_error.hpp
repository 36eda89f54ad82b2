#pragma once
// From a measured pose to the joint errors that would explain it: what the maps learn.

#include <span>
#include <vector>

#include "core/measure/reading.hpp"
#include "core/mechanism/nominal_machine.hpp"

namespace trammel {

/// Where a map was given an error: the place of the target, and the three joint errors seen there.
struct JointSample {
  double x_mm = 0;
  double y_mm = 0;
  Eigen::Vector3d error_mm = Eigen::Vector3d::Zero();
};

/// e = l(measured) - l_commanded, through the nominal inverse kinematics: the robot moves as if it
/// had been driven by cmd + e. The command counts, not the target: a reading taken under a
/// compensation tells the robot's error, not what the compensation left. Steps 2 and 6 of Sec. 4.2.
/// Throws InputError that names the reading when its measured pose is out of nominal reach or
/// absent. Precondition: every coordinate that the machine moves is measured, or stands in
/// `measured` as it is believed to be.
Eigen::Vector3d joint_error_mm(const NominalMachine& machine, const Reading& reading);

/// One sample per reading, in their order. Throws InputError where the instrument does not read
/// every coordinate that the machine moves: what a drive missed is not known then.
std::vector<JointSample> joint_samples(const NominalMachine& machine,
                                       std::span<const Reading> readings);

/// Throws InputError where a coordinate that the machine moves is not measured.
void require_all_measured(const NominalMachine& machine);

/// Samples in one place merged into their mean (repeats): a map needs one value per place.
/// Order: by first appearance. Places closer than 1e-9 mm are one.
std::vector<JointSample> merge_places(std::span<const JointSample> samples);

/// Throws InputError unless the samples lie in at least `needed` different places and are finite.
void require_places(std::span<const JointSample> samples, std::size_t needed);

}  // namespace trammel
