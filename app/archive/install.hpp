#pragma once
// The archive's own schema, schemas/archive, in the server.

#include <string>
#include <vector>

#include "app/archive/link.hpp"

namespace trammel::archive {

/// schemas/archive, in order, compiled in: the n-th text (from 1) makes version n.
const std::vector<std::string_view>& archive_schema();

/// Of the archive; 0: there is none in this database.
int archive_version(Link& link);

/// Makes the schema and the roles where there is none, or brings an older one up to this version,
/// in one transaction: for the archive's owner, who may create roles. Returns whether it did.
bool install(Link& link);

/// @throws NotFoundError  there is no archive; StoreError: a newer program's (both versions named)
void require_archive(Link& link);

}  // namespace trammel::archive
