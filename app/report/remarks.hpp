#pragma once

#include <string>
#include <vector>

#include "app/report/report.hpp"

namespace trammel::report {

/// One sentence for each method and figure whose mean error is larger after than before by more
/// than chance (95 % interval of the difference over the points), and why where that is known; and
/// one for each session that was not finished. Proof: the demo's attitude under lsq
/// (demo_test.cpp).
std::vector<std::string> remarks_on(const Report& report);

}  // namespace trammel::report
