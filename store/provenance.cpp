#include "store/provenance.hpp"

#include <sodium/version.h>
#include <sqlite3.h>

#include <Eigen/Core>

#include "core/linear/cpu_level.hpp"

namespace trammel::store {

Provenance this_program() {
  const auto number = [](int n) { return std::to_string(n); };
  return {.tool_version = TRAMMEL_VERSION,
          .git_revision = TRAMMEL_GIT_REVISION,
          .compiler = "g++ " __VERSION__,
          .libraries = "Eigen " + number(EIGEN_WORLD_VERSION) + "." + number(EIGEN_MAJOR_VERSION) +
                       "." + number(EIGEN_MINOR_VERSION) + ", SQLite " + sqlite3_libversion() +
                       ", libsodium " + SODIUM_VERSION_STRING,
          .cpu_level = name_of(cpu_level())};
}

}  // namespace trammel::store
