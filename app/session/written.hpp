#pragma once
// Gates, conditions and margins as a person writes them, under the names that settings have.

#include "app/files/fields.hpp"
#include "app/session/policy.hpp"
#include "core/plan/check.hpp"

namespace trammel::session {

/// What is absent is as in `absent`. Throws InputError with file, line and field, by the rules of
/// validate. Proof: tests/app/protocol/protocol_test.cpp.
Policy read_policy(Fields fields, const Policy& absent);

/// The same of margins and speeds.
CheckOptions read_check(Fields fields, const CheckOptions& absent);

}  // namespace trammel::session
