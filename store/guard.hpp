#pragma once

#include "store/connection.hpp"

namespace trammel::store {

/// From here on this connection can neither change nor delete what is stored, nor alter the schema,
/// attach another file or set a pragma: such statements are refused when they are prepared.
/// (Triggers refuse them too, for other programs.) guard_test.cpp.
void guard_writes(Connection& connection);

/// As guard_writes, and no row can be added either: only SELECT.
void guard_reads(Connection& connection);

}  // namespace trammel::store
