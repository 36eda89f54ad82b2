#pragma once
// Copies that are checked.

#include <filesystem>

#include "store/verify.hpp"

namespace trammel::store {

/// Copies the database as it is now to `to` (VACUUM INTO: one consistent state, also while a
/// session runs), verifies the copy, syncs it and only then gives it its name.
/// @throws InputError  `to` exists
/// @throws StoreError  the copy does not verify, or the disk is full: nothing is left at `to`
CheckReport backup(const std::filesystem::path& file, const std::filesystem::path& to);

/// All that can stop a backup before the copy: the name, and whether the database verifies.
/// @throws as backup
CheckReport backup_check(const std::filesystem::path& file, const std::filesystem::path& to);

}  // namespace trammel::store
