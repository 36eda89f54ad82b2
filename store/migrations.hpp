#pragma once
// schemas/sql, in order, compiled in.

#include <string_view>
#include <vector>

namespace trammel::store {

/// The n-th text (from 1) takes a database from version n-1 to n.
const std::vector<std::string_view>& migrations();

}  // namespace trammel::store
