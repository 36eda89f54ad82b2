#pragma once
// Copies that are checked, and the way from an older version to this one.

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

struct Migration {
  int from = 0;
  int to = 0;
  std::filesystem::path copy;  // the verified copy of what was; empty when there was nothing to do
};

/// What migrate would do; nothing is changed.
Migration planned_migration(const std::filesystem::path& file);

/// Takes an older database to this program's version in one transaction, after a verified copy
/// beside it (FILE.v1-backup, or -backup2 where that is taken). All or nothing (backup_test.cpp has
/// a fixture of each past version).
/// @throws StoreError  newer than this program; another program's; a step failed: nothing changed
Migration migrate(const std::filesystem::path& file);

}  // namespace trammel::store
