#pragma once
// The way of a database from an older version to this one.

#include <filesystem>

namespace trammel::store {

struct Migration {
  int from = 0;
  int to = 0;
  std::filesystem::path original;  // its new name; empty when there was nothing to do
};

/// What migrate would do; nothing is changed.
Migration planned_migration(const std::filesystem::path& file);

/// Takes an older database to this program's version by copying (take_over.hpp): the old chain is
/// verified, the new file made beside it, verified and synced; then the original, of which no byte
/// is changed, is renamed (FILE.v4, or FILE.v4-2 where that is taken) and the new one takes its
/// name. At each moment FILE is the whole old one or the whole new one (take_over_test.cpp has a
/// fixture of each past version).
/// @throws StoreError  newer than this program; another program's; damaged; in use, or written
///                     meanwhile; a step failed: nothing changed
Migration migrate(const std::filesystem::path& file);

}  // namespace trammel::store
