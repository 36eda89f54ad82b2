#pragma once
// Stage, tracker, thermometer and clock over one virtual robot.

#include "app/device/device.hpp"
#include "core/simulate/virtual_robot.hpp"

namespace trammel::device {

/// The stage keeps its place for as long as the program runs: a program that died finds it lost,
/// and homes.
Devices simulated(const simulate::VirtualRobot& robot, std::string identity);

/// When each point of the plan is measured: the time of all nominal moves up to it, from home, from
/// `start_s` on. Compensation does not change it. Throws InputError for a target out of reach.
std::vector<double> schedule_s(const simulate::VirtualRobot& robot, const Plan& plan,
                               double start_s);

}  // namespace trammel::device
