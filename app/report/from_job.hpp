#pragma once
// What a report shows of a job's stored result.

#include <nlohmann/json.hpp>
#include <optional>

#include "app/report/report.hpp"
#include "store/job.hpp"

namespace trammel::report {

Identification identification_of(const store::Job& lsq);
NetworkFit network_of(const store::Job& rbf);
/// The method that a contest picked.
std::string picked_of(const store::Job& contest);

/// What keeps the result of a job from being read, of an older version of its method or of a newer
/// one: such a job is left out. Empty: nothing. Proof: report_test.cpp.
std::string why_not_shown(const store::Job& job);

/// A number of the result; none where it is null.
inline std::optional<double> optional_number(const nlohmann::ordered_json& value) {
  return value.is_null() ? std::nullopt : std::optional<double>(value.get<double>());
}

}  // namespace trammel::report
