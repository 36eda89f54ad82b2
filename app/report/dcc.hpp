#pragma once
// A report as a digital calibration certificate (DCC) of PTB.

#include <string>

#include "app/report/report.hpp"
#include "app/report/tolerance.hpp"

namespace trammel::report {

/// XML in the form of PTB's DCC 3.2: instrument, conditions, the error at each point with U and k,
/// and the budget of U. Facts of the campaign fill in "laboratory", "customer", "operator",
/// "instrument" and "country"; what is not stated says so.
///
/// Well-formed (tolerance_report_test.cpp, by libxml2). Not validated: the schemas are not part of
/// this project. A simulated campaign says that it certifies nothing.
std::string dcc_xml(store::Connection& connection, const store::CampaignRow& campaign,
                    const Report& report, const JudgedPoints& points);

}  // namespace trammel::report
