#pragma once
// What a report shows of a job's stored result.

#include "app/report/report.hpp"
#include "store/job.hpp"

namespace trammel::report {

Identification identification_of(const store::Job& lsq);
NetworkFit network_of(const store::Job& rbf);

}  // namespace trammel::report
