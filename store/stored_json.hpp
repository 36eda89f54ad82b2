#pragma once

#include "store/statement.hpp"

namespace trammel::store {

/// A column that holds JSON, as text. Refused when it is nested deeper than anything of ours: a
/// stranger's file could else exhaust the stack of whoever walks the value.
/// @throws StoreError  nested deeper than 64 levels (stored_json_test.cpp)
std::string stored_json(const Statement& row, int column);

}  // namespace trammel::store
