#pragma once
// Where the temperature of a real campaign comes from.

#include <filesystem>
#include <memory>

#include "app/device/device.hpp"

namespace trammel::device {

/// Always the same, as somebody read it.
std::unique_ptr<Thermometer> fixed_thermometer(double temp_degc);

/// The last number of the last complete line of a file that a logger writes. timeout when the file
/// is older than `max_age_s`, fault when the line ends with no number between -50 and 100.
/// Proof: thermometers_test.cpp.
std::unique_ptr<Thermometer> logged_thermometer(std::filesystem::path file, double max_age_s);

}  // namespace trammel::device
