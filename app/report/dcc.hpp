#pragma once
// A report as a digital calibration certificate (DCC) of PTB.

#include <string>

#include "app/report/report.hpp"
#include "app/report/tolerance.hpp"

namespace trammel::report {

/// XML in the form of PTB's DCC 3.3.0: instrument, conditions, the error at each point with U and
/// k, and the budget of U. Facts of the campaign fill in "laboratory", "customer", "operator",
/// "instrument" and "country" (two letters); what is not stated says so.
///
/// Proof: tolerance_report_test.cpp, by libxml2 against certificate.rng, which holds what DCC 3.3.0
/// demands of the elements used here; PTB's own schemas are not part of this project. A simulated
/// campaign says that it certifies nothing.
std::string dcc_xml(store::Connection& connection, const store::CampaignRow& campaign,
                    const Report& report, const JudgedPoints& points);

}  // namespace trammel::report
