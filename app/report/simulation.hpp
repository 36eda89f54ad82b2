#pragma once
// Forward kinematics with the identified values against measurement, as the report shows it.

#include <vector>

#include "app/report/measured.hpp"
#include "app/report/report.hpp"

namespace trammel::report {

/// The group's readings against the robot as `job` believes it to be, in five rings about O_A or
/// fewer. Source: Zhang et al. 2024, Sec. 3.5, Figs. 7 and 8. Proof: report_test.cpp.
SimulationTable simulation_table(const Measured& measured, const Group& group,
                                 const store::Job& job, bool in_sample);

std::string simulation_text(const std::vector<SimulationTable>& tables);
nlohmann::ordered_json simulation_json(const std::vector<SimulationTable>& tables);

}  // namespace trammel::report
