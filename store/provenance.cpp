#include "store/provenance.hpp"

#include <sodium/version.h>
#include <sqlite3.h>

#include <Eigen/Core>

namespace trammel::store {

Provenance this_program() {
  const auto number = [](int n) { return std::to_string(n); };
  Provenance p{.tool_version = TRAMMEL_VERSION,
               .git_revision = TRAMMEL_GIT_REVISION,
               .compiler = "g++ " __VERSION__,
               .libraries = "Eigen " + number(EIGEN_WORLD_VERSION) + "." +
                            number(EIGEN_MAJOR_VERSION) + "." + number(EIGEN_MINOR_VERSION) +
                            ", SQLite " + sqlite3_libversion() + ", libsodium " +
                            SODIUM_VERSION_STRING,
               .cpu_level = "x86-64"};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
      __builtin_cpu_supports("bmi2")) {
    p.cpu_level = "x86-64-v3";
  }
#endif
  return p;
}

}  // namespace trammel::store
