#include "app/files/temporary_folder.hpp"

#include <cstdlib>
#include <string>
#include <system_error>

#include "core/error.hpp"

namespace trammel {

TemporaryFolder::TemporaryFolder() {
  std::string name = std::filesystem::temp_directory_path() / "trammel-XXXXXX";
  if (::mkdtemp(name.data()) == nullptr) {
    throw StoreError({.what = "no temporary folder can be made", .where = {.file = name}});
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace trammel
