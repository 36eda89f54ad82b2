#pragma once
// A database that gets its name once it is whole and on the disk.

#include <filesystem>

#include "store/verify.hpp"

namespace trammel::store {

/// Removes what is left of a database that came to nothing, its log included.
struct Partial {
  std::filesystem::path path;
  ~Partial();
};

/// To the disk: a file, or the names of a folder. @throws StoreError
void sync(const std::filesystem::path& path);

/// verify(), where what it finds ends the step. @throws StoreError naming the first finding
CheckReport whole(Connection& connection, const std::filesystem::path& file);

}  // namespace trammel::store
