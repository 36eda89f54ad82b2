#pragma once
// Databases of versions 1 to 4, in the form of version 5.

#include <string>
#include <vector>

#include "store/connection.hpp"

namespace trammel::store {

/// Fills `to`, an empty database with the schema of version 5, with all that the file `from` of
/// version 1 to 4 holds: every row keeps its number and its values; readings are chained and rows
/// sealed anew; each campaign's old chain head stands in taken_over. Jobs keep their key, as of
/// scheme 1. Reads `from` only, in one snapshot; verifies nothing. Proof: take_over_test.cpp.
void take_over(Connection& to, const std::filesystem::path& from, int from_version);

/// The guards refuse what a copy must write (a closed attempt): they are taken off an empty
/// database, and put on again as they were. Returns their texts.
std::vector<std::string> take_guards_off(Connection& to);

}  // namespace trammel::store
