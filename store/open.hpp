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
///                        older one's, to be written (`db migrate` first; to be read, a copy in
///                        this version's form is made in a private database); its
///                        schema is not what its version says; damaged; no permission
Connection open(const std::filesystem::path& file, Access access);

/// The file itself, to be read, whatever its version: an older one's tables are its own. For checks
/// and copies; open() gives what an older file holds as this version's tables.
Connection open_as_it_is(const std::filesystem::path& file);

/// The version of an open database.
int version_of(Connection& connection);

/// Makes the schema of `version` in an empty database.
void create_schema(Connection& connection, int version);

/// Checks application_id, version and schema. @throws StoreError as open().
void check_identity(Connection& connection);

}  // namespace trammel::store
