#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace trammel::tests {

/// Errors of `value` under schemas/`schema`; empty when it is valid. A missing schema throws.
std::string schema_errors(const nlohmann::json& value, const std::string& schema);

}  // namespace trammel::tests
