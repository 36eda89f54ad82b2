#pragma once

#include <string>

namespace trammel::store {

std::string utc_now();   // 2026-01-31T12:34:56.789Z
std::string new_uuid();  // random, version 4

}  // namespace trammel::store
