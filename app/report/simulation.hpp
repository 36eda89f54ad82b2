#pragma once
// Forward kinematics with the identified values against measurement, as the report shows it.

#include <vector>

#include "app/report/methods.hpp"
#include "app/report/report.hpp"

namespace trammel::report {

/// The readings of a comparison against the robot as its job believes it to be, in five rings about
/// O_A or fewer. Source: Zhang et al. 2024, Sec. 3.5, Figs. 7 and 8. Proof: report_test.cpp.
SimulationTable simulation_table(const Measured& measured, const Comparison& comparison);

std::string simulation_text(const std::vector<SimulationTable>& tables);
nlohmann::ordered_json simulation_json(const std::vector<SimulationTable>& tables);

}  // namespace trammel::report
