#pragma once
// A database of this program: made, checked and opened.

#include "store/connection.hpp"

namespace trammel::store {

/// "Tram" in ASCII, at byte 68 of the file.
inline constexpr int kApplicationId = 0x5472616D;

/// The version this program reads and writes: the number of texts in schemas/sql.
int newest_version();

/// Opens a laboratory's database with everything that keeps it safe: WAL, synchronous=FULL, foreign
/// keys, recursive triggers, defensive, and an authorizer that refuses every change of what is
/// stored. To be written, it is opened read-only first and checked; a small one page by page.
///
/// @throws NotFoundError  there is no such file (unless `create`)
/// @throws StoreError     not a database; another program's; a newer version's (both are named); an
///                        older one's, to be written (`db migrate` first; it opens read-only); its
///                        schema is not what its version says; damaged; no permission
Connection open(const std::filesystem::path& file, Access access);

/// The version of an open database.
int version_of(Connection& connection);

/// Makes the schema of `version` in an empty database.
void create_schema(Connection& connection, int version);

/// Checks application_id, version and schema. @throws StoreError as open().
void check_identity(Connection& connection);

}  // namespace trammel::store
