#pragma once

#include <string>

namespace trammel::store {

/// 2026-01-31T12:34:56.789Z. Throws InputError before 1970 and from 2200 on.
std::string utc_now();
std::string new_uuid();  // random, version 4

}  // namespace trammel::store
