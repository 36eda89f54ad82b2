#pragma once
// What `plan check --record` leaves behind: this plan, on this mechanism, was looked at and is
// safe.

#include <filesystem>
#include <string>
#include <vector>

#include "app/files/files.hpp"
#include "core/plan/check.hpp"

namespace trammel::session {

/// SHA-256 over the plan's points and approach and the mechanism's parameters, home and limits, as
/// hexadecimal digits: equal for what a stage would do the same.
std::string plan_sha256(const Plan& plan, const Machine& machine);

struct PlanRecord {
  std::string plan_sha256;
  CheckOptions check;  // margins and speeds it was held to
};

/// {"schema": "trammel/plan-record/1", "plan", "n_points", "plan_sha256", "check", "checked_utc",
/// "tool_version"}. Only for a plan without violations.
void write_plan_record(const std::filesystem::path& file, const Plan& plan, const Machine& machine,
                       const CheckOptions& check, Existing existing = Existing::refuse);

/// Throws NotFoundError, or InputError with file and field.
PlanRecord read_plan_record(const std::filesystem::path& file);

/// What is missing before a real stage may walk the plan, in words that say what to do; empty:
/// nothing. `file`: "" when none was given. Proof: safety_test.cpp.
std::vector<std::string> missing_record(const std::string& file, const Plan& plan,
                                        const Machine& machine, const CheckOptions& check);

}  // namespace trammel::session
