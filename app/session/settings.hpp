#pragma once

#include <cstdint>
#include <string>

#include "app/session/policy.hpp"
#include "core/plan/check.hpp"

namespace trammel::session {

/// What a session keeps beside its plan, as JSON in the store, so that a resume needs no question.
struct Settings {
  int ordinal = 1;         // of the campaign's sessions: numbers the readings of simulated devices
  double start_s = 0;      // since the campaign's start
  double end_s = 0;        // as planned
  double approach_mm = 5;  // of the plan
  std::string identity = {};  // of the devices
  CheckOptions check = {};
  Policy policy = {};
  std::string plan_sha256 = {};  // of the plan as it was checked (plan_record.hpp)
};

/// Margins and speeds under their names.
nlohmann::json check_json(const CheckOptions& check);
/// What is absent has its default.
CheckOptions read_check(const nlohmann::json& json);

std::string settings_json(const Settings& settings);

/// Throws StoreError when the text is not what settings_json wrote.
Settings read_settings(const std::string& json);

/// Sessions that this program walked through carry settings; imported and reference ones do not.
bool has_settings(const std::string& json);

}  // namespace trammel::session
